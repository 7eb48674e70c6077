"""A motor that does not turn for small commands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.mechanisms.scales import rms
from twin.parameter import Parameter


@dataclass(frozen=True)
class MotorDeadband(ChannelFault):
    """Delivered = commanded less what the motor itself swallows, up to ``torque`` either way.

    Source: Tao and Kokotovic 1996, Adaptive Control of Systems with Actuator Nonlinearities.
    """

    name: ClassVar[str] = "motor_deadband"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "actuator"
    port_unit: ClassVar[str] = "rad"
    parameters: ClassVar = {"torque": Parameter("N m", "below which nothing is delivered", "log")}
    reference: ClassVar[str] = "Tao and Kokotovic 1996"
    in_samples: ClassVar[bool] = True
    mjcf: ClassVar[str] = "a motor's fault is not part of the model: change its control"
    of_motor: ClassVar[bool] = True

    torque: float = 0.0

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels with the torque that is delivered."""
        return self._change(columns, lambda x: x - np.clip(x, -self.torque, self.torque))

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return shares of the command's RMS."""
        return tuple(cls(place, share * rms(around.reading)) for share in (0.02, 0.1, 0.4, 1.0))
