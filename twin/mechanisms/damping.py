"""A storey that is damped more or less than the model says."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import mujoco
import numpy as np

from twin.mechanisms.edits import add_drift_tendon, add_floor_tendon
from twin.mechanisms.mechanism import StructuralChange, Surroundings, floor_vector, storey_vector
from twin.parameter import Parameter
from twin.second_order import SecondOrderModel


@dataclass(frozen=True)
class Damping(StructuralChange):
    """R += change b b^T along the drift b of a storey; a dashpot more, or less of one.

    At a floor it is a dashpot to the ground's rest frame (air, a cable): with both kinds any change
    of modal damping of a two-storey frame can be written.

    Source: eqs. (2)-(6).
    """

    name: ClassVar[str] = "damping"
    verdict: ClassVar = "parameter"
    where: ClassVar = "storey"
    parameters: ClassVar = {"change": Parameter("N s/m", "added to the storey's damping")}
    reference: ClassVar[str] = "eqs. (2)-(6) of the paper"

    change: float = 0.0

    def edit(self, model: SecondOrderModel) -> SecondOrderModel:
        """Return the matrices with the damping added."""
        at_floor = self.place.startswith("floor")
        b = (floor_vector if at_floor else storey_vector)(model, self.place)
        return replace(model, R=model.R + self.change * np.outer(b, b))

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add a tendon along the drift (or the floor's displacement) with the damping."""
        add = add_floor_tendon if self.place.startswith("floor") else add_drift_tendon
        tendon = add(spec, self.place, self.name)
        tendon.damping = [self.change, 0.0, 0.0]

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return a few shares of what the storey has, less and more."""
        return tuple(cls(place, share * around.damping) for share in (-0.5, 0.5, 2.0))
