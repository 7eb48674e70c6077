"""A spring that hardens or softens with the cube of the drift."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import mujoco

from twin.mechanisms.edits import Line
from twin.mechanisms.mechanism import Law, Surroundings
from twin.mechanisms.scales import rms
from twin.parameter import Parameter


def law(drift: Any, rate: Any, memory: Any, time: Any, stiffness: Any) -> Any:
    """Return k3 d^3 [N]."""
    return stiffness * drift**3


@dataclass(frozen=True)
class CubicStiffness(Law):
    """f = k3 d^3; k3 > 0 hardens, k3 < 0 softens.

    Source: the Duffing spring, as in the Silverbox benchmark (Wigren and Schoukens 2013).
    """

    name: ClassVar[str] = "cubic_stiffness"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "drift"
    parameters: ClassVar = {"stiffness": Parameter("N/m^3", "k3 in f = k3 d^3")}
    reference: ClassVar[str] = "Duffing 1918; Wigren and Schoukens 2013"
    elastic: ClassVar[bool] = True

    stiffness: float = 0.0

    law = staticmethod(law)

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add a tendon along the drift with a polynomial stiffness."""
        tendon = Line.of(spec, self.place).tendon(self.name)
        tendon.stiffness = [0.0, 0.0, self.stiffness]

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return springs that harden or soften the storey by a share of its force."""
        per_share = around.stiffness / rms(around.drift) ** 2
        return tuple(cls(place, share * per_share) for share in (0.1, -0.1, 0.01, -0.01))
