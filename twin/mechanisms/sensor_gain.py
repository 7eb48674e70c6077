"""A sensor or a load cell whose calibration is off."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from twin.mechanisms.instrument import Instrument
from twin.mechanisms.mechanism import INPUTS, OUTPUTS, Array, ChannelFault, Surroundings
from twin.parameter import Parameter


@dataclass(frozen=True)
class SensorGain(ChannelFault):
    """Recorded = gain true.

    Source: ISO 16063-21, calibration of transducers.
    """

    name: ClassVar[str] = "sensor_gain"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    parameters: ClassVar = {"gain": Parameter("1", "recorded over true", "log")}
    reference: ClassVar[str] = "ISO 16063-21"
    of_kinds: ClassVar[frozenset[str]] = OUTPUTS | INPUTS
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"

    gain: float = 1.0

    def scaled(self, factor: float) -> Self:
        """Return a gain ``factor`` times as far off, in decibels."""
        return self.with_values({"gain": self.gain**factor})

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels with the gain."""
        return self._change(columns, lambda x: self.gain * x)

    def undo(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels without the gain."""
        return self._change(columns, lambda x: x / self.gain)

    def instrument(self, rms: float) -> Instrument:
        """Return the gain."""
        return Instrument.static(np.array([[self.gain]]))

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return gains to both sides of one."""
        return tuple(cls(place, gain) for gain in (0.5, 0.8, 0.95, 1.05, 1.25, 2.0))
