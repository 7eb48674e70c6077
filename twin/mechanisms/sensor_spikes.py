"""A channel that crackles: single samples far off, from a cable or a relay."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.mechanisms.scales import rms
from twin.signals.channel_faults import MATTERS, spikes

PASSES = 5
"""Spikes make the noise look larger and hide each other: those found are taken out, then it is
looked again, so often at most."""


@dataclass(frozen=True)
class SensorSpikes(ChannelFault):
    """Recorded = true + spikes of ``height`` at single samples, about ``often`` a second.

    They are read off the samples, not fitted: what sticks out is left out.

    Attributes:
        height: of a spike, in the channel's unit; not fitted.
        often: spikes a second; not fitted.
        seed: of where they fall when simulated; not fitted.

    Source: additive outliers, Fox 1972.
    """

    name: ClassVar[str] = "sensor_spikes"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    parameters: ClassVar = {}
    reference: ClassVar[str] = "Fox 1972, Outliers in time series"
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"
    fitted: ClassVar[bool] = False
    like_jumps: ClassVar[bool] = True

    height: float = 0.0
    often: float = 0.0
    seed: float = 0.0

    def scaled(self, factor: float) -> Self:
        """Return the fault as it is: it hides what it hides."""
        return self

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels with spikes of either sign."""
        rng = np.random.default_rng(int(self.seed))

        def crackling(x: Array) -> Array:
            hit = rng.random(len(x)) < self.often / rate_hz
            return np.where(hit, x + self.height * rng.choice([-1.0, 1.0], len(x)), x)

        return self._change(columns, crackling)

    def spoiled(self, reading: Array) -> NDArray[np.bool_]:
        """Return the samples that stick out."""
        x, hidden = np.array(reading, float), np.zeros(len(reading), bool)
        for _ in range(PASSES):
            fault = spikes(x)
            if fault is None or abs(fault.size) < MATTERS * rms(x):
                break
            hidden |= fault.hides(len(x))
            at = np.flatnonzero(hidden)
            kept = np.flatnonzero(~hidden)
            x[at] = np.interp(at, kept, x[kept])
        return hidden

    @classmethod
    def found(cls, place: str, reading: Array, rate_hz: float) -> Self | None:
        """Return the spikes in a reading, None where there are none."""
        off = np.flatnonzero(cls(place).spoiled(reading))
        if not len(off):
            return None
        inner = off[(off > 0) & (off < len(reading) - 1)]
        between = (reading[inner - 1] + reading[inner + 1]) / 2
        height = float(np.median(np.abs(reading[inner] - between))) if len(inner) else 0.0
        return cls(place, height, len(off) * rate_hz / len(reading))

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return the spikes that there are: none where nothing sticks out."""
        found = cls.found(place, around.reading, around.sampling_hz)
        return () if found is None else (found,)
