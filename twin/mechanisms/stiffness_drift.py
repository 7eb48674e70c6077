"""A storey whose stiffness creeps while it is tested: a bolt that loosens, a hall that warms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import mujoco

from twin.mechanisms.edits import Line
from twin.mechanisms.mechanism import Law, Surroundings
from twin.mechanisms.rest import free_name
from twin.parameter import Parameter

CLOCK = "stiffness_drift_clock"
"""How the names of the actuators end that keep the time."""


def law(
    drift: Any, rate: Any, memory: Any, time: Any, share_rate: Any, storey_stiffness: Any
) -> Any:
    """Return storey_stiffness rate t d [N]."""
    return storey_stiffness * share_rate * time * drift


@dataclass(frozen=True)
class StiffnessDrift(Law):
    """f = storey_stiffness rate t d, with the time t since the recording began.

    Attributes:
        storey_stiffness: what the rate refers to [N/m]; not fitted.

    Source: slowly varying systems, Poulimenos and Fassois 2006.
    """

    name: ClassVar[str] = "stiffness_drift"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "drift"
    parameters: ClassVar = {"rate": Parameter("1/s", "share of the stiffness gained a second")}
    reference: ClassVar[str] = "Poulimenos and Fassois 2006"
    mjcf: ClassVar[str] = f"the control of the actuator PLACE_{CLOCK} must be 1: it keeps the time"
    harmonics: ClassVar[int] = 1

    rate: float = 0.0
    storey_stiffness: float = 1.0

    law = staticmethod(law)

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add an actuator whose activation is the time and whose gain is the drift."""
        line = Line.of(spec, self.place)
        tendon = line.tendon(self.name)
        taken = {actuator.name.removesuffix(f"_{CLOCK}") for actuator in spec.actuators}
        clock = spec.add_actuator(
            name=f"{free_name(self.place, taken)}_{CLOCK}", target=tendon.name
        )
        clock.trntype = mujoco.mjtTrn.mjTRN_TENDON
        clock.dyntype = mujoco.mjtDyn.mjDYN_INTEGRATOR
        clock.gaintype = mujoco.mjtGain.mjGAIN_AFFINE
        slope = -self.storey_stiffness * self.rate
        clock.gainprm[:3] = [-slope * line.motion.length, slope, 0.0]

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return a few per cent over the recording, lost and gained."""
        once = 1 / max(around.duration_s, 1e-9)
        shares = (-0.1, -0.02, 0.02, 0.1)
        return tuple(cls(place, share * once, around.stiffness) for share in shares)
