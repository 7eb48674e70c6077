"""From a time column to a sampling rate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from twin.errors import RecordingError

Array = NDArray[np.float64]

JITTER = 2e-3
"""Share of a step by which a clock may wander: an error below 0.2 % at a tenth of the rate."""

COARSEST = 0.5
"""Share of a step that the last printed digit of the time may be."""

LARGEST_STEP = 1e15
"""Longer steps are damage, not time [s]."""

MOST_DIGITS = 12
"""Decimals up to which a time may be recognised as rounded in print."""


@dataclass(frozen=True)
class TimeAxis:
    """A uniform time axis.

    Attributes:
        sampling_hz: rate [Hz]; the roundest number that the times allow.
        start_s: time of the first sample [s].
        uncertainty: relative uncertainty of the rate, from the rounding of the times.
    """

    sampling_hz: float
    start_s: float
    uncertainty: float


def uniform(time: Array, at: Callable[[int], str]) -> TimeAxis:
    """Return the axis that a time column describes.

    Times may be rounded in print: to half a unit of the last digit, if that unit is half a
    step or less.

    Args:
        time: time of each sample [s], finite, at least two, (samples,).
        at: gives the file and row of a sample, the start of an error message.

    Raises:
        RecordingError: the time does not increase, or not uniformly; names the row and how far
            it is off.
    """
    with np.errstate(over="ignore"):
        steps = np.diff(time)
    if not np.all(steps < LARGEST_STEP):
        raise RecordingError(f"{at(0)}: these are no times in seconds ({time[0]:.3g} s)")
    if np.any(steps <= 0):
        bad = int(np.argmax(steps <= 0)) + 1
        raise RecordingError(
            f"{at(bad)}: time does not increase ({time[bad]:.9g} s after {time[bad - 1]:.9g} s)"
        )
    span = float(time[-1] - time[0])
    rounding = _rounding(time)
    off = _first_off(time, JITTER * float(np.median(steps)) + 2 * rounding)
    if off is not None:
        digit = _last_digit(time)
        if digit <= COARSEST * span / (len(time) - 1):
            rounding, off = digit, _first_not_rounded(time, digit)
    if off is not None:
        raise RecordingError(f"{at(off)}: {_complaint(steps, off)}")
    rate = (len(time) - 1) / span
    drift = np.abs(time - time[0] - np.arange(len(time)) / rate).max()
    uncertainty = float(max(rounding, drift)) / span
    return TimeAxis(roundest(rate, uncertainty), float(time[0]), uncertainty)


def _first_off(time: Array, allowed: float) -> int | None:
    """Return the first sample that lies off the uniform axis, or None."""
    steps = np.diff(time)
    step = float(np.median(steps))
    off = np.abs(steps - step) > allowed
    if off.any():
        return int(np.argmax(off)) + 1
    line = time[0] + np.arange(len(time)) * ((time[-1] - time[0]) / len(steps))
    # a clock that drifts by less than a hundredth of a step is still uniform
    drift = np.abs(time - line) > allowed + 0.01 * step
    return int(np.argmax(drift)) if drift.any() else None


def _first_not_rounded(time: Array, digit: float) -> int | None:
    """Return the first sample that is not a uniform time rounded to ``digit``, or None.

    Rounded times lie in a straight band as wide as the digit, whose slope cannot differ from
    that between the ends by more than a digit over the length. The width is convex in the slope.
    """
    count = np.arange(len(time))
    slope = (time[-1] - time[0]) / count[-1]
    reach = digit / count[-1]
    best = minimize_scalar(
        lambda slope: np.ptp(time - slope * count),
        bounds=(slope - reach, slope + reach),
        method="bounded",
        options={"xatol": 1e-4 * reach},
    )
    if best.fun <= 1.01 * digit:
        return None
    steps = np.diff(time)
    jumps = np.abs(steps - np.median(steps)) > 1.5 * digit
    if jumps.any():
        return int(np.argmax(jumps)) + 1
    off = time - best.x * count
    return int(np.argmax(np.abs(off - np.median(off))))


def _complaint(steps: Array, off: int) -> str:
    here, step = float(steps[max(off, 1) - 1]), float(np.median(steps))
    return (
        f"time is not uniform: a step of {here:.6g} s where steps are {step:.6g} s "
        f"(off by {100 * abs(here - step) / step:.3g} %)"
    )


def _rounding(time: Array) -> float:
    """Return how far apart neighbouring numbers are at the largest time [s]."""
    largest = np.abs(time).max()
    with np.errstate(over="ignore"):
        single = time.astype(np.float32)
    if np.array_equal(single.astype(float), time):
        return float(np.spacing(np.float32(largest)))
    return float(np.spacing(largest))


def _last_digit(time: Array) -> float:
    """Return the unit of the last decimal in which the times differ from round numbers [s]."""
    for digits in range(MOST_DIGITS):
        scaled = time * 10.0**digits
        if np.all(np.abs(scaled - np.round(scaled)) < 1e-3):
            return float(10.0**-digits)
    return 0.0


def roundest(rate: float, uncertainty: float) -> float:
    """Return the rate, or the period's inverse, of fewest digits within the uncertainty.

    Args:
        rate: measured rate [Hz].
        uncertainty: relative.
    """
    allowed = uncertainty + 2 * np.finfo(float).eps
    for digits in range(1, 16):
        candidates = (float(f"{rate:.{digits}g}"), 1 / float(f"{1 / rate:.{digits}g}"))
        nearest = min(candidates, key=lambda candidate: abs(candidate - rate))
        if abs(nearest / rate - 1) <= allowed:
            return nearest
    return rate
