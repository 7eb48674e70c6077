"""A motor whose torque arrives late."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.mechanisms.shifting import later
from twin.parameter import Parameter


@dataclass(frozen=True)
class MotorDelay(ChannelFault):
    """Delivered(t) = commanded(t - delay): the drive's and the bus's dead time.

    Source: dead time in digital control, Astrom and Wittenmark 1997.
    """

    name: ClassVar[str] = "motor_delay"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "actuator"
    parameters: ClassVar = {"delay": Parameter("s", "from command to torque", "log")}
    reference: ClassVar[str] = "Astrom and Wittenmark 1997, Computer-Controlled Systems"
    in_samples: ClassVar[bool] = True
    mjcf: ClassVar[str] = "a motor's fault is not part of the model: change its control"
    of_motor: ClassVar[bool] = True

    delay: float = 0.0

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels with the torque that is delivered."""
        return self._change(columns, lambda x: later(x, self.delay, rate_hz))

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return delays from a sample to an eighth of a period."""
        quick = max(around.natural_frequencies, default=around.sampling_hz / 10)
        sizes = sorted({1 / around.sampling_hz, 3 / around.sampling_hz, 0.03 / quick, 0.12 / quick})
        return tuple(cls(place, size) for size in sizes)
