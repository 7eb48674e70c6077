"""A channel whose range is too small."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation
from scipy.stats import norm

from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.mechanisms.scales import peak, range_ends
from twin.parameter import Parameter
from twin.recording_checks import clipped_samples
from twin.signals.channel_faults import quantisation
from twin.signals.fault import FALSE_ALARM
from twin.signals.noise_floor import noise_floor

READ_OFF = 0.005
"""Standard deviation of the logarithm of a level at which readings pile up."""


NOISE = 6.0
"""Standard deviations of the noise, three to either side, within which a reading is at the end of
the range: three in a thousand are farther."""

RINGS = 5
"""Samples over which an analyser's filter rings after a corner: two periods of its edge, at 0.78 of
half the sampling rate."""

TURNS = 1 / (np.sqrt(2) - 1)
"""Readings in a band at the summit of a parabola over those in the next band of the same width."""


@dataclass(frozen=True)
class SensorClipping(ChannelFault):
    """Recorded = true, held within plus and minus ``level``; it cannot be undone.

    Attributes:
        expected: level at which readings pile up, or NaN; not fitted.

    Source: censored observations, Tobin 1958.
    """

    name: ClassVar[str] = "sensor_clipping"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    parameters: ClassVar = {"level": Parameter("the channel's", "end of its range", "log")}
    reference: ClassVar[str] = "Tobin 1958"
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"
    fitted: ClassVar[bool] = False

    level: float = np.inf
    expected: float = np.nan

    def priors(self) -> dict[str, tuple[float, float]]:
        """Where readings pile up, the range ends."""
        if not np.isfinite(self.expected):
            return {}
        return {"level": (float(np.log(self.expected)), READ_OFF)}

    def scaled(self, factor: float) -> Self:
        """Return a range ``factor`` times as small."""
        return self._times(1 / factor, "level")

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels, clipped."""
        return self._change(columns, lambda x: np.clip(x, -self.level, self.level))

    def limit(self) -> float:
        """Return the level."""
        return self.level

    @classmethod
    def piled(cls, place: str, reading: Array) -> Self | None:
        """Return the range that ends where readings pile up, None where they do not."""
        if (ends := range_ends(reading)) is None:
            return None
        level = max(map(abs, ends))
        return cls(place, level, level)

    def spoiled(self, reading: Array) -> NDArray[np.bool_]:
        """Return the samples at the end of the range, and some to either side of each.

        To leave out by its own reading whoever stands near the end keeps those whose noise points
        inwards; and a sensor that clips before the analyser's filter makes that ring.
        """
        near = max(2 * READ_OFF * self.level, NOISE / 2 * noise_floor(reading))
        return np.asarray(binary_dilation(np.abs(reading) >= self.level - near, iterations=RINGS))

    def stands_out(self, reading: Array) -> bool:
        """Return whether more readings stand within the noise of the end than a motion has there.

        A motion that turns is a parabola in time: of two bands of width w at its summit the outer
        one holds 1 / (sqrt(2) - 1) times as many readings. And beyond the end nothing but noise is.
        """
        size, half = np.abs(reading), NOISE / 2 * noise_floor(reading)
        outer = int(np.sum(np.abs(size - self.level) < half))
        inner = int(np.sum(np.abs(size - self.level + 2 * half) < half))
        beyond = int(np.sum(size > self.level + 2 * half))
        spread = np.sqrt(outer + TURNS**2 * inner)
        return beyond == 0 and outer - TURNS * inner > -norm.ppf(FALSE_ALARM) * spread

    @classmethod
    def found(cls, place: str, reading: Array, rate_hz: float) -> Self | None:
        """Return the range that ends where readings pile up, None where they do not.

        A motion, too, lingers where it turns, but not at one value.
        """
        piled = cls.piled(place, reading)
        if piled is not None and piled.stands_out(reading):
            return piled
        if quantisation(reading) is None and clipped_samples(reading):
            level = float(np.max(np.abs(reading)))
            return cls(place, level, level)
        return None

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return where readings pile up, else the largest: one that clips has reached its end."""
        return (cls.piled(place, around.reading) or cls(place, peak(around.reading)),)
