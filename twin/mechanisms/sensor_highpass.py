"""A channel that loses the slow part: an AC-coupled input, a piezoelectric sensor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from typing import ClassVar, Self

import numpy as np
from scipy.signal import lfilter

from twin.mechanisms.instrument import Instrument
from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.parameter import Parameter


@dataclass(frozen=True)
class SensorHighpass(ChannelFault):
    """Recorded = s/(s + 2 pi corner) true; as samples by the bilinear rule, from rest.

    Source: AC coupling, IEC 61672; discretised as in Oppenheim and Schafer.
    """

    name: ClassVar[str] = "sensor_highpass"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    parameters: ClassVar = {"corner": Parameter("Hz", "below which it loses", "log")}
    reference: ClassVar[str] = "Oppenheim and Schafer, Discrete-Time Signal Processing"
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"
    valleys: ClassVar[int] = 4  # what turns a phase far is no straight line

    corner: float = 0.0

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels, filtered."""
        b, a = self._rule(rate_hz)
        return self._change(columns, lambda x: np.asarray(lfilter(b, a, x)))

    def undo(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return what was filtered, from rest."""
        b, a = self._rule(rate_hz)
        return self._change(columns, lambda x: np.asarray(lfilter(a, b, x)))

    def _rule(self, rate_hz: float) -> tuple[list[float], list[float]]:
        half = pi * self.corner / rate_hz
        return [1 / (1 + half), -1 / (1 + half)], [1.0, (half - 1) / (half + 1)]

    def instrument(self, rms: float) -> Instrument:
        """Return the low-passed part, which is taken off, as its state."""
        w = 2 * pi * self.corner
        start = np.array([[rms**2]])
        return Instrument.of(np.array([[-w]]), np.array([w]), np.array([-1.0]), 1.0, start)

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return corners from far below the first frequency to just above."""
        first = min(around.natural_frequencies, default=1.0)
        return tuple(cls(place, share * first) for share in (0.02, 0.1, 0.4, 1.5))
