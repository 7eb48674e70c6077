"""The weight above a storey or a hinge pushes it over once it leans."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import mujoco

from twin.mechanisms.edits import Line
from twin.mechanisms.mechanism import Model, StructuralChange, Surroundings
from twin.parameter import Parameter

GRAVITY = 9.81
"""[m/s^2]"""


@dataclass(frozen=True)
class PDelta(StructuralChange):
    """K += -factor g m / h p p^T, with the mass m that the port p carries and its height h.

    At a port that turns it is -factor g m h, with h from the joint to the centre of what it
    carries. The mass is taken from the model that is edited, so an added mass changes it. Factor 1
    is a storey whose weight acts in full and whose model has no gravity.

    Attributes:
        height: of the port, from its foot to what it carries [m]; not fitted.

    Source: Timoshenko and Gere 1961, Theory of Elastic Stability.
    """

    name: ClassVar[str] = "p_delta"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "drift"
    parameters: ClassVar = {"factor": Parameter("1", "share of the weight above that acts")}
    reference: ClassVar[str] = "Timoshenko and Gere 1961, Theory of Elastic Stability"
    prior: ClassVar = {"factor": (1.1, 0.1)}  # 1 for rigid links, 6/5 for clamped beams

    factor: float = 0.0
    height: float = 1.0

    def edit(self, model: Model) -> Model:
        """Return the model with the geometric stiffness."""
        port = model.port_of(self.place)
        softer = self._stiffness(model.carried(self.place), port.unit)
        return model.adding(K=-softer, along=port.row)

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add a tendon along the port with a negative stiffness."""
        line = Line.of(spec, self.place)
        softer = self._stiffness(line.motion.mass, line.motion.unit)
        line.tendon(self.name).stiffness = [-softer, 0.0, 0.0]

    def _stiffness(self, carried: float, unit: str) -> float:
        arm = self.height if unit == "rad" else 1 / self.height
        return self.factor * GRAVITY * carried * arm

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return the full weight and parts of it; none where nothing leans."""
        if not around.height:
            return ()
        return tuple(cls(place, factor, around.height) for factor in (0.3, 1.0))
