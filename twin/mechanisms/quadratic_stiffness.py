"""A spring that is stiffer one way than the other: a frame out of plumb, a shallow arch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import mujoco

from twin.mechanisms.edits import Line
from twin.mechanisms.mechanism import Law, Surroundings
from twin.mechanisms.scales import rms
from twin.parameter import Parameter


def law(drift: Any, rate: Any, memory: Any, time: Any, stiffness: Any) -> Any:
    """Return k2 d^2 [N]."""
    return stiffness * drift**2


@dataclass(frozen=True)
class QuadraticStiffness(Law):
    """f = k2 d^2, an even law: it pushes one way whichever way the port moves.

    Source: Helmholtz 1863, On the Sensations of Tone; Kovacic and Brennan 2011.
    """

    name: ClassVar[str] = "quadratic_stiffness"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "drift"
    parameters: ClassVar = {"stiffness": Parameter("N/m^2", "k2 in f = k2 d^2")}
    reference: ClassVar[str] = "Helmholtz 1863; Kovacic and Brennan 2011, The Duffing Equation"
    elastic: ClassVar[bool] = True
    harmonics: ClassVar[int] = 2

    stiffness: float = 0.0

    law = staticmethod(law)

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add a tendon with a polynomial stiffness, whose second coefficient is even."""
        tendon = Line.of(spec, self.place).tendon(self.name)
        tendon.stiffness = [0.0, self.stiffness, 0.0]

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return springs that change the storey's force by a share, both signs."""
        per_share = around.stiffness / rms(around.drift)
        return tuple(cls(place, share * per_share) for share in (0.1, -0.1, 0.01, -0.01))
