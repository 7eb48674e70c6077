"""What may be wrong with one channel, read off its own samples.

Every detector tests the hypothesis "this is a motion and white noise" and reports a fault where
its statistic is larger than chance makes it in ``FALSE_ALARM`` of all channels without the fault;
none knows a structure. What a detector cannot tell from a motion it does not report.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from twin.recording_checks import clipped_samples
from twin.signals.fault import FALSE_ALARM, Fault
from twin.signals.mains import hum
from twin.signals.mains import tapers as slepian
from twin.signals.noise_floor import noise_floor
from twin.signals.whitening import (
    HALF,
    innovations,
    local_scale,
    noise_level,
    prediction_error_filter,
)

Array = NDArray[np.float64]

MATTERS = 1e-3
"""Share of a channel's RMS below which an error is not worth a word: sensors are calibrated to half
a per cent at best (ISO 16063-21)."""

SLOW = 8.0
"""Periods a record up to which a motion counts as its baseline: 14 tapers, 13 degrees of freedom
for an offset and ten for a bend."""

BENDS = 3
"""A baseline is a polynomial of this degree."""

OF_A_BLOW = 3
"""Numbers that a blow at a stop has: when, how hard and how long. A wrong sample that leaves no
more innovations beyond the noise than that could be one."""

LEAVES = 3.0
"""Steps of the converter by which a held value is left at least: a smooth signal that stays L
samples within one step lies within (1 + 2/L)^2 steps one sample further, 2.8 for three."""


def channel_faults(x: Array, rate_hz: float, kind: str = "acc") -> tuple[Fault, ...]:
    """Return everything that is wrong with a channel.

    Args:
        x: samples, (samples,).
        rate_hz: sampling rate [Hz].
        kind: quantity (``twin.quantity``): the baseline of an acceleration is known to be zero, a
            blow's force is no spike.
    """
    pulses = kind in ("force", "torque")
    found = [clipping(x), dead_tail(x), dropouts(x, pulses), hum(x, rate_hz), quantisation(x)]
    if kind in ("acc", "angacc"):
        found += [offset(x), drift(x)]
    if not pulses:
        found.append(spikes(x))
    least = MATTERS * float(np.sqrt(np.mean(np.square(x)))) if len(x) else 0.0
    counted = ("clipping", "dead_tail", "dropout")
    return tuple(f for f in found if f and (f.name in counted or abs(f.size) >= least))


def clipping(x: Array) -> Fault | None:
    """Return whether the channel ran into the ends of its range.

    Plateaus at the largest or smallest value that are entered and left steeply: no smooth signal
    has one, whatever its quantisation, so there is no false alarm to state.
    """
    count = clipped_samples(np.asarray(x, float))
    if not count:
        return None
    return Fault("clipping", count, (), f"{count} samples stand at the end of its range")


def dead_tail(x: Array) -> Fault | None:
    """Return whether the channel stands still from some sample on to the end.

    Of pairs of neighbours outside the tail a share p is equal; n pairs have a run of L equal ones
    by chance with probability n p^L at most. A value at which the record also begins is rest.
    """
    x = np.asarray(x, float)
    moving = np.flatnonzero(np.diff(x))
    if not len(moving):
        return None
    first = int(moving[-1]) + 1
    length = len(x) - 1 - first
    rests = x[first] == x[0] or x[first] == np.median(x[:first])
    if rests or not _rare(length, int(np.count_nonzero(np.diff(x[:first]) == 0)), first):
        return None
    words = f"it stands still from sample {first + 1} to the end"
    return Fault("dead_tail", length + 1, ((first, len(x) - 1),), words)


def dropouts(x: Array, pulses: bool = False) -> Fault | None:
    """Return whether stretches of the channel repeat one value and then jump.

    As for ``dead_tail``, and the run is left by more than a smooth signal can that stayed within
    one step for so long. The ends of the range are no dropouts, and rest is none: zero or the
    median, unless a motion falls to it in a jump; pulses do.
    """
    x = np.asarray(x, float)
    steps = np.abs(np.diff(x))
    if not np.any(steps):
        return None
    smallest = float(np.min(steps[steps > 1e-9 * np.ptp(x)]))
    starts = np.concatenate([[0], np.flatnonzero(steps) + 1])
    lengths = np.diff(np.append(starts, len(x)))
    ties = int(np.sum(lengths - 1))
    ends, rest = (x.min(), x.max()), (float(np.median(x)), 0.0)
    found = []
    for first, length in zip(starts, lengths, strict=True):
        last = int(first + length - 1)
        if int(length) < 3 or first == 0 or last + 1 == len(x) or x[first] in ends:
            continue
        if x[first] in rest and (pulses or steps[first - 1] <= LEAVES * smallest):
            continue
        others = ties - int(length - 1)
        if steps[last] > LEAVES * smallest and _rare(int(length - 1), others, len(x)):
            found.append((int(first), last))
    if not found:
        return None
    count = sum(last - first for first, last in found)
    return Fault("dropout", count, tuple(found), f"{count} samples repeat the one before them")


def spikes(x: Array) -> Fault | None:
    """Return whether single samples are wrong.

    A wrong sample leaves the shape of the prediction-error filter in the innovations, a blow to
    the structure leaves one innovation: the matched filter's output, over the size of the
    innovations around it, is Student's where nothing is wrong; and what is left beside the shape
    must be noise, too.
    """
    x = np.asarray(x, float)
    if len(x) < 4 * HALF or not np.ptp(x):
        return None
    taps = prediction_error_filter(x)
    e = innovations(x, taps)
    scale = local_scale(e)
    left = np.minimum(np.arange(len(e), 0, -1), len(taps))  # the record may end before the shape
    norm = np.sqrt(np.cumsum(taps**2))[left - 1]
    size = _against(e, taps) / norm**2  # of a wrong sample k, at k
    local = np.maximum(scale, scale[np.arange(len(e)) + left - 1])
    level = noise_level(len(x))
    found: list[int] = []
    for k in np.flatnonzero(np.abs(size) * norm > level * local).tolist():
        before = e[max(k - len(taps), 0) : k]
        calm = len(before) == len(taps) and np.max(np.abs(before)) <= level * local[k]
        if calm:
            found += _wrong_together(e, taps, k, level * local[k], float(local[k]))
    found = _peaks(found, np.abs(size))
    if not found:
        return None
    largest = float(np.max(np.abs(size[found])))
    words = f"{len(found)} single samples are off, by up to {largest:.3g}"
    return Fault("spikes", largest, tuple((k, k) for k in found), words)


def _wrong_together(e: Array, taps: Array, first: int, beyond: float, scale: float) -> list[int]:
    """Return wrong samples, so close that their shapes overlap; none if it is not all they leave.

    They are believed where they stand for more innovations beyond the noise than as many blows
    would, which have ``OF_A_BLOW`` numbers each.

    Args:
        e: innovations, (samples,).
        taps: the shape that one leaves in them.
        first: where the first of them is.
        beyond: what an innovation is beyond the noise from.
        scale: standard deviation of the innovations.
    """
    at = [first]
    while True:
        rest = e[first : max(at) + len(taps)].copy()
        blows = int(np.sum(np.abs(rest) > beyond)) / OF_A_BLOW
        shapes = np.zeros((len(rest), len(at)))
        for i, k in enumerate(at):
            seen = taps[: len(e) - k]
            shapes[k - first : k - first + len(seen), i] = seen
        sizes = np.linalg.lstsq(shapes, rest, rcond=None)[0]
        rest -= shapes @ sizes
        small = np.abs(sizes) * np.sqrt(np.sum(shapes**2, axis=0)) <= beyond
        if np.any(small) or blows < len(at):
            return []
        if float(rest @ rest) <= stats.chi2.isf(FALSE_ALARM, len(rest)) * scale**2:
            return at
        another = first + int(np.argmax(np.abs(_against(rest, taps))))
        if min(abs(another - k) for k in at) <= 1:
            return []  # it is no single sample
        at.append(another)


def _against(e: Array, taps: Array) -> Array:
    """Return the matched filter's output, (samples,): zeros follow what is over."""
    return np.correlate(np.append(e, np.zeros(len(taps) - 1)), taps, "valid")


def offset(x: Array) -> Fault | None:
    """Return whether an acceleration has a mean: Student's test on its slowest part.

    Slepian tapers take from the record what is slower than ``SLOW`` periods a record; the constant
    is tested against what else is there.
    """
    slow, basis = _baseline(x)
    one = basis[:, 0]
    mean = float(one @ slow / (one @ one))
    rest = slow - mean * one
    spread = np.sqrt(float(rest @ rest) / (len(slow) - 1) / float(one @ one))
    limit = -float(stats.t.ppf(FALSE_ALARM / 2, len(slow) - 1))
    if abs(mean) <= limit * spread or abs(mean) < 1e-12 * np.max(np.abs(x)):
        return None
    return Fault("offset", mean, (), f"its mean is {mean:.3g}, not zero")


def drift(x: Array) -> Fault | None:
    """Return whether the baseline of an acceleration bends: Fisher's test on its slowest part.

    A polynomial of third degree, its mean left to ``offset``, against what else is there.
    """
    slow, basis = _baseline(x)
    value = np.linalg.lstsq(basis, slow, rcond=None)[0]
    rest = slow - basis @ value
    flat = slow - basis[:, 0] * (basis[:, 0] @ slow / (basis[:, 0] @ basis[:, 0]))
    freedom = len(slow) - BENDS - 1
    less = max(float(flat @ flat - rest @ rest), 0.0)
    ratio = (less / BENDS) / max(float(rest @ rest) / freedom, 1e-300)
    at = np.linspace(-1, 1, 101)
    size = float(np.ptp(np.polynomial.legendre.legvander(at, BENDS)[:, 1:] @ value[1:]))
    if ratio <= stats.f.isf(FALSE_ALARM, BENDS, freedom) or size < 1e-12 * np.max(np.abs(x)):
        return None
    return Fault("drift", size, (), f"its baseline drifts by {size:.3g}")


def _baseline(x: Array) -> tuple[Array, Array]:
    """Return what the slowest tapers see of a record, and of the polynomials that bend it."""
    x = np.asarray(x, float)
    count = round(2 * SLOW) - 2
    if len(x) < 4 * count:
        return np.zeros(count), np.eye(count, BENDS + 1)
    windows = slepian(len(x), SLOW, count)
    at = np.linspace(-1, 1, len(x))
    return windows @ x, windows @ np.polynomial.legendre.legvander(at, BENDS)


def quantisation(x: Array) -> Fault | None:
    """Return whether the steps of the converter are its noise: the step over sqrt(12) is it all.

    Readings of a converter are whole multiples of its step, which chance never makes of readings
    without one. It is a fault where rounding brings at least half of the noise's power.
    """
    x = np.asarray(x, float)
    levels = np.unique(x)
    if len(levels) < 3 or 4 * len(levels) > len(x):
        return None
    gaps = np.diff(levels)
    step = float(np.min(gaps[gaps > 1e-9 * np.ptp(x)]))
    counts = (levels - levels[0]) / step
    if np.max(np.abs(counts - np.round(counts))) > 0.01:
        return None
    floor = noise_floor(x)
    if step**2 / 12 < floor**2 / 2:
        return None
    words = f"its steps of {step:.3g} are coarser than its noise: {len(levels)} different values"
    return Fault("quantisation", step, (), words)


def _rare(length: int, ties: int, pairs: int) -> bool:
    """Return whether a run of so many equal pairs is rarer than a false alarm may be."""
    share = (ties + 1) / (pairs + 2)
    return length >= 2 and np.log(max(pairs, 1)) + length * np.log(share) < np.log(FALSE_ALARM)


def _peaks(at: list[int], size: Array) -> list[int]:
    """Return of samples beside each other the largest."""
    kept: list[int] = []
    for k in at:
        if kept and k - kept[-1] <= 1:
            if size[k] > size[kept[-1]]:
                kept[-1] = k
        else:
            kept.append(k)
    return kept
