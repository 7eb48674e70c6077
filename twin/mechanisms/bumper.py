"""An elastic stop that the storey hits on one side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import mujoco
import numpy as np

from twin.mechanisms.edits import FAR, Line
from twin.mechanisms.mechanism import Law, Surroundings
from twin.mechanisms.scales import peak
from twin.parameter import Parameter


def law(drift: Any, rate: Any, memory: Any, time: Any, stiffness: Any, gap: Any) -> Any:
    """Return the force of the stop [N]."""
    side = np.sign(gap)
    return stiffness * side * np.maximum(side * (drift - gap), 0.0)


@dataclass(frozen=True)
class Bumper(Law):
    """f = k max(d - gap, 0) for gap > 0, f = k min(d - gap, 0) for gap < 0.

    Source: piecewise linear oscillator, Shaw and Holmes 1983; measured on a frame, the bumper of
    the Los Alamos three-storey structure, Figueiredo et al. 2009.
    """

    name: ClassVar[str] = "bumper"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "drift"
    parameters: ClassVar = {
        "stiffness": Parameter("N/m", "of the stop", "log"),
        "gap": Parameter("m", "drift at which it is hit; its sign is the side"),
    }
    reference: ClassVar[str] = "Shaw and Holmes 1983; Figueiredo et al. 2009, LA-14393"
    abrupt: ClassVar[bool] = True
    elastic: ClassVar[bool] = True
    at_times: ClassVar[bool] = True

    stiffness: float = 0.0
    gap: float = 1.0

    law = staticmethod(law)

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add a tendon along the drift whose spring has a dead range up to the gap."""
        line = Line.of(spec, self.place)
        tendon = line.tendon(self.name)
        tendon.stiffness = [self.stiffness, 0.0, 0.0]
        low, high = (self.gap, FAR) if self.gap < 0 else (-FAR, self.gap)
        line.dead_range(tendon, low, high)

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return stops on both sides, hit early to late, of half to five times the stiffness."""
        far = peak(around.drift)
        return tuple(
            cls(place, share * around.stiffness, side * part * far)
            for side in (1, -1)
            for part in (0.25, 0.5, 0.8)
            for share in (0.5, 5.0)
        )
