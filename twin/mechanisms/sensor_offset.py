"""A force whose zero is off: an amplifier's, a weight that hangs on the cell, a motor's current."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

from twin.mechanisms.mechanism import INPUTS, Array, ChannelFault, Surroundings
from twin.mechanisms.scales import rms
from twin.parameter import Parameter


@dataclass(frozen=True)
class SensorOffset(ChannelFault):
    """Recorded = true + offset, of a force or a torque.

    The mean of an output is taken off where it cannot be the motion's; that of a force moves a
    structure without springs, so it is estimated.

    Source: Janot, Gautier and Brunot 2019, Data set and reference models of EMPS (there an offset
    of the motor's amplifier and of its friction).
    """

    name: ClassVar[str] = "sensor_offset"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    parameters: ClassVar = {"offset": Parameter("the channel's", "of its zero")}
    of_kinds: ClassVar = INPUTS
    in_samples: ClassVar[bool] = True
    reference: ClassVar[str] = "Janot, Gautier and Brunot 2019, EMPS"
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"

    offset: float = 0.0

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels with the offset."""
        return self._change(columns, lambda x: x + self.offset)

    def undo(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels without it."""
        return self._change(columns, lambda x: x - self.offset)

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return a hundredth and a tenth of the force, either way."""
        scale = rms(around.reading)
        return tuple(cls(place, share * scale) for share in (0.01, -0.01, 0.1, -0.1))
