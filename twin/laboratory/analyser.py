"""The spectrum analyser: anti-alias filter and sampler, and the time base they ask for."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import ExperimentError
from twin.laboratory.excitation import TimeBase, finite, positive
from twin.signals.low_pass import LowPass, anti_alias, decimate

Array = NDArray[np.float64]

LEAST_PHYSICS_HZ = 1024.0
"""Physics runs at this rate or above: RK4 then keeps frequency and damping within 0.02 %."""

LEAST_FACTOR = 8
"""Physics samples to one sample of the record, at least: the filter needs room to work in."""

SAMPLES_IN_A_PULSE = 16
"""Physics samples in a hammer's pulse; straight lines then miss 0.3 % of its impulse."""

MOST_PHYSICS_SAMPLES = 10_000_000
"""A longer simulation would not fit the memory of a laptop."""


@dataclass(frozen=True)
class Analyser:
    """Samples every channel alike, behind a linear-phase filter whose delay is taken out.

    Flat within 1e-5 up to the cut-off over 1.28, more than 100 dB down from 1.22 times the
    cut-off on; with the default cut-off nothing aliases into the band up to sampling_hz / 2.56.

    Attributes:
        sampling_hz: sampling rate of the record [Hz].
        duration_s: length of the record [s], rounded to whole samples.
        cut_off_hz: where half of the amplitude is left [Hz]; None for half the sampling rate.
        physics_hz: rate of the simulation [Hz], a multiple of the sampling rate; None for the
            smallest one that is at least 1024 Hz, 8 times the sampling rate and gives a hammer's
            pulse 16 samples.

    Raises:
        ExperimentError: a value out of its range.

    Source: the paper's 32 Hz, 32 s and cut-off of 16 Hz.
    """

    sampling_hz: float = 32.0
    duration_s: float = 32.0
    cut_off_hz: float | None = None
    physics_hz: float | None = None

    def __post_init__(self) -> None:
        positive(self.sampling_hz, "the sampling rate", "hertz")
        positive(self.duration_s, "the duration", "seconds")
        if not self.duration_s * self.sampling_hz < MOST_PHYSICS_SAMPLES:
            raise ExperimentError(
                f"{self.duration_s:g} s at {self.sampling_hz:g} Hz are more than the "
                f"{MOST_PHYSICS_SAMPLES:,} samples one test may have"
            )
        if self.samples < 2:
            raise ExperimentError(
                f"{self.duration_s:g} s at {self.sampling_hz:g} Hz are fewer than two samples"
            )
        if self.cut_off_hz is not None:
            positive(self.cut_off_hz, "the cut-off frequency", "hertz")
            if self.cut_off_hz > self.sampling_hz / 2:
                raise ExperimentError(
                    f"the cut-off of {self.cut_off_hz:g} Hz is above the Nyquist frequency "
                    f"{self.sampling_hz / 2:g} Hz of {self.sampling_hz:g} Hz sampling"
                )
        if self.physics_hz is not None:
            positive(self.physics_hz, "the physics rate", "hertz")
            factor = self.physics_hz / self.sampling_hz
            if factor < 2 or abs(factor - round(factor)) > 1e-9 * factor:
                raise ExperimentError(
                    f"the physics rate {self.physics_hz:g} Hz must be a multiple (2 or more) of "
                    f"the sampling rate {self.sampling_hz:g} Hz"
                )

    @property
    def samples(self) -> int:
        """Samples in the record."""
        return round(self.duration_s * self.sampling_hz)

    def factor(self, shortest_s: float | None = None) -> int:
        """Return how many physics samples there are to a sample of the record.

        Args:
            shortest_s: the shortest feature of the excitation [s], or None.
        """
        if self.physics_hz is not None:
            return round(self.physics_hz / self.sampling_hz)
        least_hz = max(LEAST_PHYSICS_HZ, LEAST_FACTOR * self.sampling_hz)
        if shortest_s is not None:
            least_hz = max(least_hz, SAMPLES_IN_A_PULSE / shortest_s)
        return math.ceil(least_hz / self.sampling_hz - 1e-9)

    def filter(self, factor: int) -> LowPass:
        """Return the anti-alias filter for a physics rate of ``factor`` times the sampling rate."""
        return anti_alias(self.sampling_hz, factor, self.cut_off_hz)

    def time_base(self, shortest_s: float | None = None, settle_s: float = 0.0) -> TimeBase:
        """Return the instants to simulate: settling time, record, filter's reach at both ends.

        Args:
            shortest_s: the shortest feature of the excitation [s], or None.
            settle_s: time before the record during which a shaker runs already [s].

        Raises:
            ExperimentError: the settling time is negative or the simulation too long.
        """
        finite(settle_s, "the settling time", "s")
        factor = self.factor(shortest_s)
        length_s = settle_s + self.duration_s
        if length_s * self.sampling_hz * factor > MOST_PHYSICS_SAMPLES:
            raise ExperimentError(
                f"{length_s:g} s at {self.sampling_hz * factor:g} Hz are more than the "
                f"{MOST_PHYSICS_SAMPLES:,} physics samples one test may have"
            )
        settle = math.ceil(settle_s * self.sampling_hz - 1e-9)
        reach = self.filter(factor).reach
        first = -settle * factor - reach
        count = reach + (self.samples - 1) * factor + 1 - first
        rate_hz = self.sampling_hz * factor
        return TimeBase(rate_hz, factor, first, count, self.samples, settle)

    def sample(self, history: Array, base: TimeBase) -> Array:
        """Return the record of a history on ``base``, filtered with true data at both ends."""
        filter_ = self.filter(base.factor)
        start = -base.first - filter_.reach
        return decimate(history[start:], base.factor, filter_)


def straight_lines(history: Array) -> Array:
    """Return the samples that stand, in the analyser's band, for straight lines between samples.

    A force that runs straight from sample to sample has the spectrum of its samples times
    sinc^2(f / rate); the analyser's filter sees the force, not the samples. Three taps give that
    factor within (pi f / rate)^4 / 15: at 1024 Hz, in the band to 16 Hz, 4e-7 instead of 8e-4.
    """
    padded = np.pad(history, 1, mode="edge")
    return (padded[:-2] + 10 * padded[1:-1] + padded[2:]) / 12
