"""A storey that is stiffer or softer than the model says."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import mujoco
import numpy as np

from twin.mechanisms.edits import add_drift_tendon
from twin.mechanisms.mechanism import StructuralChange, Surroundings, storey_vector
from twin.parameter import Parameter
from twin.second_order import SecondOrderModel


@dataclass(frozen=True)
class Stiffness(StructuralChange):
    """K += change b b^T along the drift b of a storey; a spring more, or less of one.

    Source: eqs. (2)-(6).
    """

    name: ClassVar[str] = "stiffness"
    verdict: ClassVar = "parameter"
    where: ClassVar = "storey"
    parameters: ClassVar = {"change": Parameter("N/m", "added to the storey's stiffness")}
    reference: ClassVar[str] = "eqs. (2)-(6) of the paper"

    change: float = 0.0

    def edit(self, model: SecondOrderModel) -> SecondOrderModel:
        """Return the matrices with the stiffness added."""
        b = storey_vector(model, self.place)
        return replace(model, K=model.K + self.change * np.outer(b, b))

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add a tendon along the drift with the stiffness."""
        tendon = add_drift_tendon(spec, self.place, self.name)
        tendon.stiffness = [self.change, 0.0, 0.0]

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return a few shares of what the storey has, less and more."""
        return tuple(cls(place, share * around.stiffness) for share in (-0.2, -0.05, 0.05, 0.2))
