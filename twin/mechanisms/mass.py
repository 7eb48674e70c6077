"""A body that is heavier or lighter than the model says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import mujoco

from twin.mechanisms.edits import add_point_mass, body_named, set_mass
from twin.mechanisms.mechanism import Model, StructuralChange, Surroundings
from twin.model.linear import LinearModel
from twin.parameter import Parameter


@dataclass(frozen=True)
class Mass(StructuralChange):
    """M += change sum_i t_i t_i^T with the rows t of a body's translation along x, y, z.

    At a body it is the mass at its centre, at a site a point mass there, eccentric perhaps; its
    weight acts as well.

    Attributes:
        in_proportion: 1 where a body is heavier throughout, so that its moment of inertia grows
            with its mass; 0 where something small is added.

    Source: eqs. (2)-(6).
    """

    name: ClassVar[str] = "mass"
    verdict: ClassVar = "parameter"
    on: ClassVar = "body"
    parameters: ClassVar = {"change": Parameter("kg", "added to the body's mass")}
    reference: ClassVar[str] = "eqs. (2)-(6) of the paper"
    stage: ClassVar[int] = 0

    change: float = 0.0
    in_proportion: float = 0.0

    def edit(self, model: Model) -> Model:
        """Return the model with the mass added."""
        loaded = model.loaded(self.place, self.change)
        if not self.in_proportion or not isinstance(model, LinearModel):
            return loaded
        body = model.bodies[self.place]
        return loaded.adding(M=self.in_proportion * self.change / body.mass * body.spin)

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Change the body's mass, or put a point mass at the site."""
        site = spec.site(self.place)
        if spec.body(self.place) is None and site is not None:
            if self.change:
                add_point_mass(spec, site, self.change)
            return
        body = body_named(spec, self.place)
        if self.change:
            set_mass(spec, body, change=self.change, in_proportion=self.in_proportion)

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return a few shares of what the body has, less and more."""
        return tuple(cls(place, share * around.mass) for share in (-0.2, -0.05, 0.05, 0.2))
