"""The weight above a storey pushes it over once it leans."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import mujoco
import numpy as np

from twin.linearise import linearise
from twin.mechanisms.edits import add_drift_tendon, number_of
from twin.mechanisms.mechanism import StructuralChange, Surroundings, storey_vector
from twin.parameter import Parameter
from twin.second_order import SecondOrderModel

GRAVITY = 9.81
"""[m/s^2]"""


@dataclass(frozen=True)
class PDelta(StructuralChange):
    """K += -factor g m / h b b^T, with the mass m of the floors above, h the storey's height.

    The mass is taken from the model that is edited, so an added mass changes it. Factor 1 is a
    storey whose weight acts in full and whose model has no gravity.

    Attributes:
        height: of the storey [m]; not fitted.

    Source: Timoshenko and Gere 1961, Theory of Elastic Stability.
    """

    name: ClassVar[str] = "p_delta"
    verdict: ClassVar = "missing_physics"
    where: ClassVar = "storey"
    parameters: ClassVar = {"factor": Parameter("1", "share of the weight above that acts")}
    reference: ClassVar[str] = "Timoshenko and Gere 1961, Theory of Elastic Stability"
    prior: ClassVar = {"factor": (1.15, 0.3)}  # 1 for rigid links, 6/5 for clamped beams

    factor: float = 0.0
    height: float = 1.0

    def edit(self, model: SecondOrderModel) -> SecondOrderModel:
        """Return the matrices with the geometric stiffness."""
        b = storey_vector(model, self.place)
        return replace(model, K=model.K - self._stiffness(model) * np.outer(b, b))

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add a tendon along the drift with a negative stiffness."""
        tendon = add_drift_tendon(spec, self.place, self.name)
        if self.factor:
            model = linearise(spec.copy().compile()).second_order()
            tendon.stiffness = [-self._stiffness(model), 0.0, 0.0]

    def _stiffness(self, model: SecondOrderModel) -> float:
        above = [
            model.M[j, j]
            for j, name in enumerate(model.coordinates)
            if name.startswith("floor") and number_of(name) >= number_of(self.place)
        ]
        return float(self.factor * GRAVITY * np.sum(above) / self.height)

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return the full weight and parts of it."""
        return tuple(cls(place, factor, around.height) for factor in (0.3, 1.0))
