"""A storey, a column or a joint that is stiffer or softer than the model says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import mujoco

from twin.mechanisms.edits import Line
from twin.mechanisms.mechanism import Model, StructuralChange, Surroundings
from twin.parameter import Parameter


@dataclass(frozen=True)
class Stiffness(StructuralChange):
    """K += change p p^T along a port p; a spring more, or less of one.

    Source: eqs. (2)-(6).
    """

    name: ClassVar[str] = "stiffness"
    verdict: ClassVar = "parameter"
    on: ClassVar = "drift"
    parameters: ClassVar = {"change": Parameter("N/m", "added to the port's stiffness")}
    reference: ClassVar[str] = "eqs. (2)-(6) of the paper"

    change: float = 0.0

    def edit(self, model: Model) -> Model:
        """Return the model with the stiffness added."""
        return model.adding(K=self.change, along=model.port(self.place))

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add a tendon along the port with the stiffness."""
        tendon = Line.of(spec, self.place).tendon(self.name)
        tendon.stiffness = [self.change, 0.0, 0.0]

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return a few shares of what the port has, less and more."""
        return tuple(cls(place, share * around.stiffness) for share in (-0.2, -0.05, 0.05, 0.2))
