"""A floor that is heavier or lighter than the model says."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import mujoco
import numpy as np

from twin.mechanisms.edits import body_of, set_mass
from twin.mechanisms.mechanism import StructuralChange, Surroundings, floor_vector
from twin.parameter import Parameter
from twin.second_order import SecondOrderModel


@dataclass(frozen=True)
class Mass(StructuralChange):
    """M += change at a floor.

    Source: eqs. (2)-(6).
    """

    name: ClassVar[str] = "mass"
    verdict: ClassVar = "parameter"
    where: ClassVar = "floor"
    parameters: ClassVar = {"change": Parameter("kg", "added to the floor's mass")}
    reference: ClassVar[str] = "eqs. (2)-(6) of the paper"
    stage: ClassVar[int] = 0

    change: float = 0.0

    def edit(self, model: SecondOrderModel) -> SecondOrderModel:
        """Return the matrices with the mass added."""
        b = floor_vector(model, self.place)
        return replace(model, M=model.M + self.change * np.outer(b, b))

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Change the body's mass."""
        body = body_of(spec, self.place)
        if self.change:
            set_mass(spec, body, change=self.change)

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return a few shares of what the floor has, less and more."""
        return tuple(cls(place, share * around.mass) for share in (-0.2, -0.05, 0.05, 0.2))
