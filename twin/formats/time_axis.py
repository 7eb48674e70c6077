"""From a time column to a sampling rate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

from twin.errors import RecordingError

Array = NDArray[np.float64]

JITTER = 2e-3
"""Share of a step by which a clock may wander: an error below 0.2 % at a tenth of the rate."""

COARSEST = 0.5
"""Share of a step that the last printed digit of the time may be."""

LARGEST_STEP = 1e15
"""Longer steps are damage, not time [s]."""

RATE_KNOWN = 1e-4
"""Share of the length that the last printed digit may be where it is more than half a step: the
rate is then known as closely as a rate given beside the times has to agree with them."""

GAP_FIT = 0.2
"""Share of a step by which a gap of missing samples may differ from a whole number of steps."""

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

    Times may be rounded in print, to decimals or to significant digits: to half a unit of the last
    digit, if that unit is half a step or less, or so little that the rate is known all the same.

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
    back = steps < 0
    if np.any(back):
        raise RecordingError(_not_increasing(time, int(np.argmax(back)) + 1, at))
    span = float(time[-1] - time[0])
    rounding = _rounding(time)
    off = _first_off(time, JITTER * float(np.median(steps)) + 2 * rounding)
    if off is not None:
        coarsest = max(COARSEST * span / (len(time) - 1), RATE_KNOWN * span)
        for digits in (_last_decimal(time), _last_significant(time)):
            if not 0 < digits.max() <= coarsest:
                continue
            if (found := _rounded_steps(time, digits)) is not None:
                uncertainty = max((found[1] - found[0]) / sum(found), rounding / span)
                rate = roundest(2 / sum(found), uncertainty)
                return TimeAxis(rate, float(time[0]), uncertainty)
            off = max(off, _first_not_rounded(time, digits))
    if off is not None and np.any(steps == 0):
        raise RecordingError(_not_increasing(time, int(np.argmax(steps == 0)) + 1, at))
    if off is not None:
        raise RecordingError(f"{at(off)}: {_complaint(steps, off)}")
    rate = (len(time) - 1) / span
    drift = np.abs(time - time[0] - np.arange(len(time)) / rate).max()
    uncertainty = float(max(rounding, drift)) / span
    return TimeAxis(roundest(rate, uncertainty), float(time[0]), uncertainty)


def _not_increasing(time: Array, bad: int, at: Callable[[int], str]) -> str:
    return (
        f"{at(bad)}: time does not increase ({time[bad]:.9g} s after {time[bad - 1]:.9g} s); "
        "cut the file there, or leave the time column out and give the rate (--rate HZ)"
    )


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


def _rounded_steps(time: Array, digits: Array) -> tuple[float, float] | None:
    """Return the shortest and the longest step whose uniform times round to these, or None.

    Rounded times lie in a straight band as wide as their digits, whose slope cannot differ from
    that between the ends by more than a digit over the length. What the band lacks in width is
    convex in the slope.
    """
    count = np.arange(len(time))
    largest = float(digits.max())
    slope = float((time[-1] - time[0]) / count[-1])
    reach = largest / count[-1]
    allowed = 0.01 * largest

    def lacking(slope: float) -> float:
        line = time - slope * count
        return float(np.max(line - digits / 2) - np.min(line + digits / 2))

    # in reaches, so that the tolerance of the search is one of the reach
    found = minimize_scalar(
        lambda x: lacking(slope + x * reach),
        bounds=(-1, 1),
        method="bounded",
        options={"xatol": 1e-4},
    )
    if found.fun > allowed:
        return None
    best = slope + found.x * reach

    def end(towards: float) -> float:
        if lacking(towards) <= allowed or lacking(best) == allowed:
            return towards
        return float(brentq(lambda s: lacking(s) - allowed, best, towards, xtol=1e-6 * reach))

    return end(slope - reach), end(slope + reach)


def _first_not_rounded(time: Array, digits: Array) -> int:
    """Return the first sample that is not a uniform time rounded to its digit."""
    steps = np.diff(time)
    jumps = np.abs(steps - np.median(steps)) > 1.5 * digits.max()
    if jumps.any():
        return int(np.argmax(jumps)) + 1
    good, bad = 2, len(time)
    while bad - good > 1:  # the longest beginning that is uniform
        middle = (good + bad) // 2
        if _rounded_steps(time[:middle], digits[:middle]) is None:
            bad = middle
        else:
            good = middle
    return bad - 1


def _complaint(steps: Array, off: int) -> str:
    here, step = float(steps[max(off, 1) - 1]), float(np.median(steps))
    apart = f"a step of {here:.6g} s where steps are {step:.6g} s"
    missing = round(here / step) - 1 if step > 0 else 0
    if missing >= 1 and abs(here / step - missing - 1) < GAP_FIT:
        lost = f"{missing} sample{'s are' if missing > 1 else ' is'} missing"
        return (
            f"time is not uniform: {apart} (off by {100 * abs(here - step) / step:.3g} %): {lost}; "
            "cut the file there into two recordings"
        )
    return (
        f"time is not uniform: {apart} (off by {100 * abs(here - step) / step:.3g} %); resample it "
        "to equal steps, or give the rate (--rate HZ) and leave the time column out"
    )


def _rounding(time: Array) -> float:
    """Return how far apart neighbouring numbers are at the largest time [s]."""
    largest = np.abs(time).max()
    with np.errstate(over="ignore"):
        single = time.astype(np.float32)
    if np.array_equal(single.astype(float), time):
        return float(np.spacing(np.float32(largest)))
    return float(np.spacing(largest))


def _last_decimal(time: Array) -> Array:
    """Return the unit of the last decimal that was printed [s], zero where none is seen."""
    for digits in range(MOST_DIGITS):
        scaled = time * 10.0**digits
        if np.all(np.abs(scaled - np.round(scaled)) < 1e-3):
            return np.full(len(time), 10.0**-digits)
    return np.zeros(len(time))


def _last_significant(time: Array) -> Array:
    """Return the unit of the last digit [s] of times printed as "%.7g" does, or zeros."""
    size = np.abs(time)
    decade = np.floor(np.log10(np.where(size > 0, size, 1.0)) + 1e-12)
    for digits in range(2, MOST_DIGITS):
        unit = 10.0 ** (decade - digits + 1)
        scaled = time / unit
        if np.all(np.abs(scaled - np.round(scaled)) < 1e-3):
            return np.where(size > 0, unit, 0.0)
    return np.zeros(len(time))


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
