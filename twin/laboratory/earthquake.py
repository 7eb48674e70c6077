"""Recorded earthquakes as the ground's acceleration."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.arrays import frozen
from twin.errors import ExperimentError
from twin.laboratory.excitation import TimeBase, finite, positive
from twin.signals.resampling import resample

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Earthquake:
    """A recorded ground motion, played on a shake table.

    The table follows the band-limited signal through the recorded samples; it rests before the
    first and after the last of them.

    Attributes:
        acceleration: recorded ground acceleration [m/s^2], (samples,).
        rate_hz: its sampling rate [Hz].
        peak: largest acceleration to scale the recorded samples to [m/s^2], or None to leave
            them as they are.
        delay_s: from the record's start to the first sample [s].
        name: which earthquake, used in messages.

    Raises:
        ExperimentError: a value out of its range, samples that are not finite or all zero.
    """

    acceleration: Array
    rate_hz: float
    peak: float | None = None
    delay_s: float = 0.0
    name: str = "ground motion"

    kind = "earthquake"
    moves_the_ground = True
    shortest_s = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "acceleration", frozen(self.acceleration, float))
        positive(self.rate_hz, f"the sampling rate of {self.name}", "hertz")
        finite(self.delay_s, "the delay of a ground motion", "s")
        if self.peak is not None:
            positive(self.peak, "the peak acceleration", "m/s^2")
        if self.acceleration.ndim != 1 or len(self.acceleration) < 2:
            raise ExperimentError(f"{self.name}: a ground motion needs at least two samples")
        if not np.all(np.isfinite(self.acceleration)):
            raise ExperimentError(f"{self.name}: the acceleration has samples that are not finite")
        if not np.any(self.acceleration):
            raise ExperimentError(f"{self.name}: the acceleration is zero throughout")

    @property
    def duration_s(self) -> float:
        """Time from the first to the last sample [s]."""
        return (len(self.acceleration) - 1) / self.rate_hz

    def history(self, base: TimeBase, rng: np.random.Generator) -> Array:
        """Return the ground's acceleration [m/s^2], (base.samples,). Uses no random numbers."""
        scale = 1.0
        if self.peak is not None:
            scale = self.peak / float(np.abs(self.acceleration).max())
        try:
            motion = scale * resample(self.acceleration, self.rate_hz, base.rate_hz)
        except ValueError as error:
            raise ExperimentError(f"{self.name}: {error}") from None
        history = np.zeros(base.samples)
        start = math.ceil(self.delay_s * base.rate_hz - 1e-9) - base.first
        if start < base.samples:
            part = history[start : start + len(motion)]
            part[:] = motion[: len(part)]
        return history
