"""A channel whose steps are coarse: a range far too large, too few bits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.signals.channel_faults import quantisation


@dataclass(frozen=True)
class SensorQuantisation(ChannelFault):
    """Recorded = step round(true / step): noise of variance step^2 / 12 and no more information.

    It is read off the samples, not fitted.

    Attributes:
        step: from one reading to the next, in the channel's unit; not fitted.

    Source: Widrow and Kollar 2008, Quantization Noise.
    """

    name: ClassVar[str] = "sensor_quantisation"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    parameters: ClassVar = {}
    reference: ClassVar[str] = "Widrow and Kollar 2008, Quantization Noise"
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"
    fitted: ClassVar[bool] = False

    step: float = 0.0

    def scaled(self, factor: float) -> Self:
        """Return the fault as it is: a step is what it is."""
        return self

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels in whole steps."""
        if not self.step:
            return self._change(columns, np.copy)
        return self._change(columns, lambda x: self.step * np.round(x / self.step))

    def noise(self) -> float:
        """Return the standard deviation of what rounding adds."""
        return float(self.step / np.sqrt(12))

    @classmethod
    def found(cls, place: str, reading: Array, rate_hz: float) -> Self | None:
        """Return the step of a reading, None where it is not coarse."""
        fault = quantisation(reading)
        return None if fault is None else cls(place, fault.size)

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return the step that there is: none where the reading is not coarse."""
        found = cls.found(place, around.reading, around.sampling_hz)
        return () if found is None else (found,)
