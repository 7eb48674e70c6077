"""Play: a connection that bears only once its slack is taken up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import mujoco
import numpy as np

from twin.mechanisms.edits import Line
from twin.mechanisms.mechanism import Law, Surroundings
from twin.mechanisms.scales import TINY, peak
from twin.parameter import Parameter

KNOWN = 0.01
"""Share to which what the part takes over is its own stiffness, as a good drawing knows one: what
differs by more is a change of the storey's stiffness, which has a name of its own."""


def law(
    drift: Any, rate: Any, memory: Any, time: Any, stiffness: Any, gap: Any, replaced: Any
) -> Any:
    """Return the force of the part, less what it takes over [N]."""
    beyond = np.maximum(drift - np.abs(gap), 0.0) + np.minimum(drift + np.abs(gap), 0.0)
    return stiffness * beyond - replaced * drift


@dataclass(frozen=True)
class Clearance(Law):
    """f = stiffness deadzone(d, gap) - replaced d, with deadzone(d, g) = d - clip(d, -g, g).

    With ``replaced`` = ``stiffness`` a part of the storey's own stiffness has play. A brace that
    was added and has play is the same beside a storey that is stiffer by as much.

    Source: Shaw and Holmes 1983; backlash as in Nordin and Gutman 2002.
    """

    name: ClassVar[str] = "clearance"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "drift"
    parameters: ClassVar = {
        "stiffness": Parameter("N/m", "of the part that has play", "log"),
        "gap": Parameter("m", "play to either side", "log"),
        "replaced": Parameter("N/m", "of the storey's own stiffness that the part takes over"),
    }
    reference: ClassVar[str] = "Shaw and Holmes 1983; Nordin and Gutman 2002"
    abrupt: ClassVar[bool] = True
    elastic: ClassVar[bool] = True
    at_times: ClassVar[bool] = True
    shares: ClassVar = {"replaced": ("stiffness", 1.0, KNOWN)}  # the storey's own part

    stiffness: float = 0.0
    gap: float = 1e-3
    replaced: float = 0.0

    def scaled(self, factor: float) -> Self:
        """Return a part ``factor`` times as stiff, taking over as much more."""
        return self._times(factor, "stiffness", "replaced")

    law = staticmethod(law)

    def priors(self) -> dict[str, tuple[float, float]]:
        """It is a part of the storey itself that has play.

        It is held to the stiffness that a fit starts from; its rounds follow.
        """
        own = max(self.stiffness, TINY)
        return {"replaced": (own, KNOWN * own)}

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add a tendon whose spring has a dead range, and one that takes stiffness away."""
        line = Line.of(spec, self.place)
        tendon = line.tendon(self.name)
        tendon.stiffness = [self.stiffness, 0.0, 0.0]
        line.dead_range(tendon, -abs(self.gap), abs(self.gap))
        if self.replaced:
            less = line.tendon(f"{self.name}_replaced")
            less.stiffness = [-self.replaced, 0.0, 0.0]

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return parts of a tenth to most of the storey, with little to much play."""
        far = peak(around.drift)
        return tuple(
            cls(place, share * around.stiffness, part * far, share * around.stiffness)
            for share in (0.1, 0.3, 0.7)
            for part in (0.02, 0.1, 0.3, 0.7)
        )
