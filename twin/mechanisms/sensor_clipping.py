"""A channel whose range is too small."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.mechanisms.scales import peak, range_ends
from twin.parameter import Parameter
from twin.recording_checks import clipped_samples
from twin.signals.channel_faults import quantisation
from twin.signals.noise_floor import noise_floor

READ_OFF = 0.005
"""Standard deviation of the logarithm of a level at which readings pile up."""


NOISE = 6.0
"""Standard deviations of the noise within which a reading is at the end of the range: one in 10^9
is farther."""


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
        """Return the samples at the end of the range."""
        near = max(2 * READ_OFF * self.level, NOISE * noise_floor(reading))
        return np.asarray(np.abs(reading) >= self.level - near)

    @classmethod
    def found(cls, place: str, reading: Array, rate_hz: float) -> Self | None:
        """Return the range that ends where readings pile up, None where they do not.

        Nothing but noise lies beyond the end of a range; what piles up and goes beyond is a motion.
        """
        piled = cls.piled(place, reading)
        if piled is not None:
            beyond = np.max(np.abs(reading)) - piled.level
            if beyond <= max(2 * READ_OFF * piled.level, NOISE * noise_floor(reading)):
                return piled
        if quantisation(reading) is None and clipped_samples(reading):
            level = float(np.max(np.abs(reading)))
            return cls(place, level, level)
        return None

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return where readings pile up, else the largest: one that clips has reached its end."""
        return (cls.piled(place, around.reading) or cls(place, peak(around.reading)),)
