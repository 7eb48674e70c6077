"""A channel whose range is too small."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, find_objects, label
from scipy.stats import binom, norm

from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.mechanisms.scales import peak, range_ends
from twin.parameter import Parameter
from twin.recording_checks import clipped_samples
from twin.signals.channel_faults import quantisation
from twin.signals.fault import FALSE_ALARM, MOST_HIDDEN
from twin.signals.interpolation import interpolated
from twin.signals.noise_floor import noise_floor

READ_OFF = 0.005
"""Standard deviation of the logarithm of a level at which readings pile up."""


NOISE = 6.0
"""Standard deviations of the noise, three to either side, within which a reading is at the end of
the range: three in a thousand are farther."""

RINGS = 10
"""Samples over which an analyser's filter rings after a corner: that of eighth order, whose edge is
at 0.78 of half the sampling rate, falls to a hundredth in them."""

NEAR = 0.02
"""Share of the level by which readings at the end of a range differ behind an analyser's filter."""

OVERSHOOT = 0.18
"""By what share of its step a sharp low-pass overshoots at most (Gibbs): 9 % of what is twice the
range where it goes from end to end."""

FARTHEST = 0.33
"""The same of a filter without linear phase: a Butterworth low-pass of eighth order overshoots by
16.3 % of its step."""

BANDS, LEVELS = 50, 5
"""Bands of readings' magnitudes, ``NEAR`` of the largest wide, and how many of the most crowded
ones are asked whether the range ends there."""

EITHER = float(np.sqrt(FALSE_ALARM / LEVELS))
"""Chance of each of two independent tests by which both together alarm falsely as seldom as said,
``LEVELS`` times."""

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

    def exceeded(self, reading: Array) -> bool:
        """Return whether readings go farther than a filter's overshoot."""
        return bool(np.max(np.abs(reading)) > (1 + FARTHEST) * self.level)

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
        inwards; and a sensor that clips before the analyser's filter makes that ring, and of a blow
        it leaves less than the level.
        """
        near = max(OVERSHOOT * self.level, NOISE / 2 * noise_floor(reading))
        ends = np.abs(reading) >= self.level - near
        for rings in range(RINGS, 0, -1):
            wide = binary_dilation(ends, iterations=rings)
            if np.mean(wide) <= MOST_HIDDEN:
                return np.asarray(wide)
        return np.asarray(ends)

    def stands_out(self, reading: Array) -> bool:
        """Return whether more readings stand within the noise of the end than a motion has there.

        And beyond the end nothing but noise is.
        """
        half = NOISE / 2 * noise_floor(reading)
        beyond = np.any(np.abs(reading) > self.level + 2 * half)
        return not beyond and self._crowd(reading, half, TURNS) < FALSE_ALARM

    def _crowd(self, reading: Array, half: float, ratio: float) -> float:
        """Return the chance that so many readings are at the level, give or take ``half``.

        Where they are ``ratio`` times as many as in the next band as wide. A motion that turns is a
        parabola in time: of two bands of width w at its one summit the outer one holds
        1 / (sqrt(2) - 1) times as many; of summits of all heights it holds fewer than the inner.
        """
        size = np.abs(reading)
        outer = int(np.sum(np.abs(size - self.level) < half))
        inner = int(np.sum(np.abs(size - self.level + 2 * half) < half))
        spread = np.sqrt(max(outer + ratio**2 * inner, 1.0))
        return float(norm.sf((outer - ratio * inner) / spread))

    @classmethod
    def found(cls, place: str, reading: Array, rate_hz: float) -> Self | None:
        """Return the range that ends where readings pile up, None where they do not.

        A motion, too, lingers where it turns, but not at one value, or no farther than it goes.
        """
        piled = cls.piled(place, reading)
        if piled is not None and piled.stands_out(reading):
            return piled
        if (cut := cls.cut_off(place, reading)) is not None:
            return cut
        if quantisation(reading) is None and clipped_samples(reading):
            level = float(np.max(np.abs(reading)))
            return cls(place, level, level)
        return None

    @classmethod
    def cut_off(cls, place: str, reading: Array) -> Self | None:
        """Return the range beyond which the motion went, None where it did not.

        An analyser's filter spreads the readings about the end of a range. What the channel does
        elsewhere tells how far it goes there: at summits of a sound channel as often less far than
        it was read as farther, and rather less, for noise made them summits. That and their number
        are two tests, of which a sound channel passes at least one.
        """
        size = np.abs(reading)
        best: tuple[float, Self] | None = None
        for level in _crowded(size):
            outer = size > (1 - NEAR) * level
            end = float(np.median(size[outer]))
            told = cls(place, end, end)
            crowd = told._crowd(reading, NEAR * end, 1.0)
            if crowd > EITHER:
                continue
            motion = interpolated(reading, outer)
            if motion is None:
                continue
            farther = (motion - reading) * np.sign(reading)
            summits = [np.sum(farther[where]) > 0 for where in find_objects(label(outer)[0])]
            chance = float(binom.sf(sum(summits) - 1, len(summits), 0.5))
            if chance < EITHER and (best is None or chance * crowd < best[0]):
                best = chance * crowd, told
        return None if best is None else best[1]

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return where readings pile up, else the largest: one that clips has reached its end."""
        return (cls.piled(place, around.reading) or cls(place, peak(around.reading)),)


def _crowded(size: Array) -> list[float]:
    """Return magnitudes about which there are more readings than farther in and farther out."""
    if not np.max(size, initial=0.0) > 0:
        return []
    count, edges = np.histogram(size, BANDS, (0.0, float(np.max(size))))
    padded = np.pad(count, 1, mode="constant", constant_values=(count[0], 0))
    around = (padded[:-2] + padded[2:]) / 2
    excess = (count - around) / np.sqrt(around + 1)
    first = BANDS // 4  # nearer to nothing there is no end of a range
    order = first + np.argsort(-excess[first:])[:LEVELS]
    return [float((edges[i] + edges[i + 1]) / 2) for i in order]
