"""What is wrong with a channel's samples, read off them: no model of the structure is needed.

Each threshold is the size that chance alone reaches once in ``CHANCE`` records.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.special import ndtri

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

CHANCE = 1e3
"""Records without a fault of which one is said to have it."""

MAINS_HZ = (50.0, 60.0)
WANDER_HZ = 0.2
"""Frequencies of the mains, and how far a grid's strays (ENTSO-E: 0.2 Hz at most)."""

AROUND_HZ = 3.0
"""Band to either side of a line from which the level of what else there is comes."""

AROUND_SAMPLES = 33
"""Samples around one by which it is judged: a period of what a record still resolves well."""

OUT = 3.0
"""Power over the strongest of N frequencies around it that one frequency of noise exceeds in
prod k / (k + 3) = 6 / N^3 of the cases: once in 30,000 for N = 60."""

FINER = 4
"""Frequencies between those that a record resolves, so that no line falls in between."""

LEVELS = 8
"""A quantised record has fewer different values than samples, by this factor at least."""

ISOLATED = 0.25
"""A spike stands alone: its neighbours stray by less than this share of it."""


def runs(reading: Array) -> list[tuple[int, int]]:
    """Return first and last sample of each run of equal readings, two at least."""
    same = np.diff(reading) == 0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], same, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def held(reading: Array) -> Mask:
    """Return the samples of a dropout, (samples,): the reading stands still, then jumps.

    Readings are equal by chance where they are quantised. A run is a dropout where it is longer
    than chance makes it, at the rate at which equal pairs begin elsewhere, and ends in a jump of
    more than two of the smallest steps there are. Runs at the ends of the range are clipping.
    """
    x = np.asarray(reading, float)
    out = np.zeros(len(x), bool)
    found = runs(x)
    if not found:
        return out
    steps = np.abs(np.diff(x))
    smallest = float(np.min(steps[steps > 0], initial=np.inf))
    begins = len(found) / max(len(x) - sum(b - a for a, b in found), 1)
    chance = min(max(begins, 1 / len(x)), 0.9)
    longest = max(np.log(CHANCE * len(x)) / np.log(1 / chance), 2.0)
    low, high = float(np.min(x)), float(np.max(x))
    for first, last in found:
        jump = abs(x[last + 1] - x[last]) if last + 1 < len(x) else np.inf
        if last - first > longest and jump > 2 * smallest and low < x[first] < high:
            out[first + 1 : last + 1] = True
    return out


def spikes(reading: Array) -> Mask:
    """Return single samples that stand out from their neighbours, (samples,).

    What a sample departs by from the cubic through the two before and the two behind it is judged
    by the median of such departures around it. Once it is put right nothing near it may stand out:
    a hit lasts longer than a sample.
    """
    x = np.asarray(reading, float)
    out = np.zeros(len(x), bool)
    if len(x) < 2 * AROUND_SAMPLES:
        return out
    departure = np.abs(_departures(x))
    level = median_filter(departure, AROUND_SAMPLES, mode="reflect") / 0.6745
    most = -float(ndtri(0.5 / (CHANCE * len(x))))
    whole = float(np.median(level[level > 0])) if np.any(level) else 0.0
    beyond = departure > most * np.maximum(level, whole)
    for n in np.flatnonzero(beyond):
        near = x[n - 4 : n + 5].copy()
        if len(near) < 9 or departure[n] < np.max(departure[n - 2 : n + 3]):
            continue
        near[4] += _departures(near)[4] * -1.0
        out[n] = np.max(np.abs(_departures(near)[2:7])) < ISOLATED * departure[n]
    return out


def _departures(x: Array) -> Array:
    """Return how far each sample is from the cubic through its four neighbours, (samples,)."""
    p = np.pad(x, 2, mode="reflect", reflect_type="odd")
    return np.asarray(x - (4 * (p[1:-3] + p[3:-1]) - p[:-4] - p[4:]) / 6)


def quantum(reading: Array) -> float | None:
    """Return the step of a coarsely quantised reading, None where it is not coarse.

    All readings are then whole multiples of the step, give or take a thousandth of it.
    """
    values = np.unique(np.asarray(reading, float))
    if len(values) < 3 or len(values) * LEVELS > len(reading):
        return None
    gaps = np.diff(values)
    step = float(np.min(gaps))
    step = float(np.median(gaps[gaps < 1.5 * step]))
    off = (values - values[0]) / step
    return step if np.max(np.abs(off - np.round(off))) < 1e-3 * max(off[-1], 1.0) else None


@dataclass(frozen=True)
class Line:
    """A sinusoid in a reading.

    Attributes:
        frequency: [Hz].
        rms: in the reading's unit.
        above: its power over that of the strongest frequency around it.
    """

    frequency: float
    rms: float
    above: float


def hum(reading: Array, rate_hz: float) -> Line | None:
    """Return the line of the mains in a reading, None where none stands out.

    The line is the strongest sinusoid within ``WANDER_HZ`` of 50 or 60 Hz. It stands out where it
    is ``OUT`` times the strongest of the frequencies around it: a structure's or a multisine's own
    lines have neighbours.
    """
    x = np.asarray(reading, float) - float(np.mean(reading))
    if len(x) < 4 * rate_hz / AROUND_HZ:
        return None
    window = np.hanning(len(x))
    fine = FINER * len(x)
    power = np.abs(np.fft.rfft(window * x, fine)) ** 2
    frequency = np.arange(len(power)) * rate_hz / fine
    best = None
    for mains in MAINS_HZ:
        off = np.abs(frequency - mains)
        near = off < WANDER_HZ + 2 * rate_hz / len(x)
        beside = (off < AROUND_HZ) & ~(off < WANDER_HZ + 5 * rate_hz / len(x))
        if mains + AROUND_HZ > rate_hz / 2 or not np.any(near) or not np.any(beside):
            continue
        peak = int(np.argmax(np.where(near, power, 0.0)))
        above = float(power[peak] / max(np.max(power[beside]), 1e-300))
        if above > OUT and (best is None or above > best.above):
            best = Line(float(frequency[peak]), _rms(x * window, window, peak, fine), above)
    return best


def _rms(x: Array, window: Array, bin_: int, count: int) -> float:
    turn = 2 * np.pi * bin_ * np.arange(len(x)) / count
    waves = np.column_stack([np.cos(turn), np.sin(turn)]) * window[:, None]
    a = np.linalg.lstsq(waves, x, rcond=None)[0]
    return float(np.sqrt(np.sum(a**2) / 2))
