"""What every excitation is: a description that yields a history on a time base."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from twin.errors import ExperimentError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TimeBase:
    """The instants of a simulation: the record and what lies before and after it.

    Attributes:
        rate_hz: physics rate, ``factor`` times the sampling rate [Hz].
        factor: physics samples to one sample of the record.
        first: index of the first physics sample; sample 0 is the record's first instant.
        samples: number of physics samples.
        record_samples: number of samples in the record, at the sampling rate.
        settle_samples: samples before the record, at the sampling rate, during which a shaker
            that runs all the time runs already.
    """

    rate_hz: float
    factor: int
    first: int
    samples: int
    record_samples: int
    settle_samples: int = 0

    @property
    def index(self) -> NDArray[np.int64]:
        """Number of each physics sample, counted from the record's first instant, (samples,)."""
        return self.first + np.arange(self.samples)

    @property
    def time(self) -> Array:
        """Time of each physics sample after the record's first instant [s], (samples,)."""
        return self.index / self.rate_hz

    @property
    def sampling_hz(self) -> float:
        """Sampling rate of the record [Hz]."""
        return self.rate_hz / self.factor

    @property
    def duration_s(self) -> float:
        """Length of the record [s]."""
        return self.record_samples / self.sampling_hz

    def running(self) -> slice:
        """Return the physics samples from the settling time to the end of the history."""
        return slice(max(0, -self.first - self.settle_samples * self.factor), self.samples)


class Excitation(Protocol):
    """A hammer, a shaker's signal or a ground motion.

    The history is the true force [N] at the physics rate, a straight line between its samples;
    for a ground motion it is the ground's acceleration [m/s^2].
    """

    @property
    def kind(self) -> str:
        """One word for tables and file names: hammer, random, multisine, sweep, earthquake."""

    @property
    def moves_the_ground(self) -> bool:
        """True where the history is a ground acceleration, not a force."""

    @property
    def shortest_s(self) -> float | None:
        """Duration of the shortest feature, which the physics rate has to resolve [s], or None."""

    def history(self, base: TimeBase, rng: np.random.Generator) -> Array:
        """Return the history, (base.samples,)."""


def positive(value: float, what: str, unit: str) -> None:
    """Raise ExperimentError unless ``value`` is finite and larger than zero."""
    if not (math.isfinite(value) and value > 0):
        raise ExperimentError(f"{what} must be a positive number of {unit}, not {value:g}")


def finite(value: float, what: str, unit: str) -> None:
    """Raise ExperimentError unless ``value`` is finite and not negative."""
    if not (math.isfinite(value) and value >= 0):
        raise ExperimentError(f"{what} must not be negative [{unit}], not {value:g}")


def checked_band(band_hz: tuple[float, float], lowest: float = 0.0) -> None:
    """Raise ExperimentError unless ``lowest`` <= band_hz[0] < band_hz[1], both finite."""
    low, high = band_hz
    if not (math.isfinite(low) and math.isfinite(high) and lowest <= low < high):
        raise ExperimentError(
            f"a band goes from a lower to a higher frequency [Hz], at least {lowest:g}, "
            f"not from {low:g} to {high:g}"
        )
