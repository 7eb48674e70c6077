"""What may be wrong with one of two channels, read off both of them.

As in ``twin.signals.channel_faults``: a fault is reported where chance makes as much of it in
``FALSE_ALARM`` of all sound pairs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special, stats

from twin.signals.fault import FALSE_ALARM
from twin.signals.noise_floor import noise_floor

Array = NDArray[np.float64]

SEGMENTS = 16
"""Stretches of a record whose delays show a clock that is off: 14 degrees of freedom."""

DECAY = 7.0
"""The weight at the end of a record is exp(-7), a thousandth."""

STILL = 0.05
"""Share of the peak that the first hundredth of a record stays below where it begins at rest."""

FARTHEST = 0.02
"""Rates of clocks that are tried: a wrong rate typed in is rounder, a free clock better."""

LONGEST, MOST_RATES = 8192, 200
"""Samples and rates (to either side) that are looked at, for time."""

EXCITED = 1e-2
"""Share of the largest power from which on a spectral line says something of a delay."""


@dataclass(frozen=True)
class PairFault:
    """A fault between two channels.

    Attributes:
        name: identical, polarity or clock.
        size: the factor between identical channels; how many standard deviations the energy is
            below zero; the difference of two clocks over their rate.
        words: one short sentence.
    """

    name: str
    size: float
    words: str


def identical(x: Array, y: Array) -> PairFault | None:
    """Return whether two channels are one signal, but for a factor and an offset.

    They then differ by no more than the rounding of their converters, everywhere. Noise of their
    own, of a step or more, makes that as good as impossible: a pair of samples is then within it
    in less than two thirds of the cases, a record of 40 in one of ten million.
    """
    x, y = np.asarray(x, float), np.asarray(y, float)
    a, b = x - x.mean(), y - y.mean()
    if len(x) < 40 or not np.any(a) or not np.any(b):
        return None
    factor = float(a @ b / (a @ a))
    rounding = (_step(y) + abs(factor) * _step(x)) / 2
    rounding += 1e-12 * float(np.max(np.abs(b)))
    left = b - factor * a
    if factor == 0 or np.max(np.abs(left - np.median(left))) > rounding * (1 + 1e-6):
        return None
    same = "is the same signal" if abs(factor - 1) < 1e-9 else f"is {factor:.6g} times the other"
    return PairFault("identical", factor, same)


def reversed_polarity(force: Array, acceleration: Array, rate_hz: float) -> PairFault | None:
    """Return whether force and acceleration of one point and direction disagree in sign.

    The mobility V(s)/F(s) of a passive structure at the point of the force has a positive real
    part wherever s has one (Brune 1931). Both records are weighed with exp(-at), which puts s to
    a + iw and leaves nothing of the end; the real part of conj(F) A/s is summed over the lines that
    the force excites. White noise of the acceleration moves the sum by a normal amount of known
    size; a fault is reported where it is too far below zero for it.

    Returns:
        None, too, for a structure that is in motion when the record begins.
    """
    f = np.asarray(force, float) - np.median(force)
    a = np.asarray(acceleration, float) - np.median(acceleration)
    head = max(len(a) // 100, 2)
    if any(np.max(np.abs(x[:head])) > STILL * np.max(np.abs(x)) for x in (f, a)):
        return None
    time = np.arange(len(f)) / rate_hz
    decay = DECAY / time[-1]
    weight = np.exp(-decay * time)
    F, A = np.fft.rfft(weight * f), np.fft.rfft(weight * a)
    s = decay + 2j * np.pi * np.fft.rfftfreq(len(f), 1 / rate_hz)
    use = (np.abs(F) ** 2 > EXCITED * np.max(np.abs(F[1:]) ** 2)) & (np.arange(len(F)) > 1)
    energy = float(np.sum(np.real(np.conj(F[use]) * A[use] / s[use])))
    per_line = np.abs(F[use] / s[use]) ** 2
    noise = noise_floor(a) * float(np.sqrt(np.sum(weight**2) * np.sum(per_line) / 2))
    limit = -float(special.ndtri(FALSE_ALARM))
    if energy >= 0 or -energy <= limit * noise:
        return None
    return PairFault("polarity", -energy / max(noise, 1e-300), "its sign is reversed")


def clock(x: Array, y: Array, rate_hz: float) -> PairFault | None:
    """Return whether the delay between two channels grows: their clocks differ.

    The delay of each stretch of the record comes from the phase of its cross spectrum against
    that of the whole; Student's test of the slope of delay over time.
    """
    length = len(x) // SEGMENTS
    if length < 64:
        return None
    window = np.hanning(length)
    shape = (SEGMENTS, length)
    X, Y = (
        np.fft.rfft(window * np.asarray(v, float)[: SEGMENTS * length].reshape(shape), axis=1)
        for v in (x, y)
    )
    omega = 2 * np.pi * np.fft.rfftfreq(length, 1 / rate_hz)
    power = np.mean(np.abs(X) ** 2, axis=0)
    use = (power > EXCITED * power[2:].max(initial=0.0)) & (np.arange(len(omega)) > 1)
    if np.count_nonzero(use) < 2 or not np.any(Y):
        return None
    H = np.sum(np.conj(X) * Y, axis=0) / np.maximum(np.sum(np.abs(X) ** 2, axis=0), 1e-300)
    told = H[use] * X[:, use]
    across = np.sum(np.imag(np.conj(told) * Y[:, use]) * omega[use], axis=1)
    along = np.sum(np.abs(told) ** 2 * omega[use] ** 2, axis=1)
    if np.any(along <= 1e-6 * along.max()):
        return None  # a decay: its end says nothing
    delay = -across / along
    middle = (np.arange(SEGMENTS) + 0.5) * length / rate_hz
    fit = stats.linregress(middle, delay)
    limit = -float(stats.t.ppf(FALSE_ALARM / 2, SEGMENTS - 2))
    if not np.isfinite(fit.stderr) or abs(fit.slope) <= limit * fit.stderr:
        return None
    words = f"its clock differs by {1e6 * fit.slope:.3g} millionths"
    return PairFault("clock", float(fit.slope), words)


def clock_far_off(x: Array, y: Array, rate_hz: float) -> PairFault | None:
    """Return whether one channel follows from the other only if its clock runs at another rate.

    ``clock`` needs delays that stay below a period of what moves. Here y is read at other rates,
    up to ``FARTHEST`` off in steps that move the end of the record by a quarter of the period of
    its mean frequency; each time the share of y's power is taken that no linear relation to x
    explains, over stretches of the record. It is a fault where another rate explains half of
    what the stated one leaves, and by more than chance.
    """
    count = min(len(x), LONGEST)
    length = count // SEGMENTS
    if length < 32:
        return None
    at = np.arange(count)
    x, y = (np.asarray(v, float)[:count] - np.mean(v[:count]) for v in (x, y))
    spectrum = np.abs(np.fft.rfft(y * np.hanning(count))) ** 2
    if not np.any(spectrum) or not np.any(x):
        return None
    cycles = float(np.sum(np.arange(len(spectrum)) * spectrum) / np.sum(spectrum))
    steps = int(min(np.ceil(4 * FARTHEST * max(cycles, 1.0)), MOST_RATES))
    window = np.hanning(length)
    shape = (SEGMENTS, length)
    X = np.fft.rfft(window * x[: SEGMENTS * length].reshape(shape), axis=1)
    power = np.sum(np.abs(X) ** 2, axis=0)
    use = power > EXCITED * power.max()

    def unexplained(off: float) -> float:
        read = np.interp(at / (1 + off), at, y)
        Y = np.fft.rfft(window * read[: SEGMENTS * length].reshape(shape), axis=1)[:, use]
        told = np.abs(np.sum(np.conj(X[:, use]) * Y, axis=0)) ** 2 / power[use]
        return float(1 - np.sum(told) / max(np.sum(np.abs(Y) ** 2), 1e-300))

    rates = np.linspace(-FARTHEST, FARTHEST, 2 * steps + 1)
    left = np.array([unexplained(off) for off in rates])
    best, here = int(np.argmin(left)), left[steps]
    data = np.count_nonzero(use) * (SEGMENTS - 1)
    chance = np.log(len(rates)) - np.log(FALSE_ALARM)
    if abs(best - steps) < 2 or left[best] > here / 2 or data * np.log(here / left[best]) < chance:
        return None
    words = f"its clock is off by about {100 * rates[best]:.2g} %"
    return PairFault("clock", float(rates[best]), words)


def _step(x: Array) -> float:
    """Return the smallest difference between two readings."""
    gaps = np.diff(np.unique(x))
    gaps = gaps[gaps > 1e-9 * np.ptp(x)]
    return float(gaps.min()) if len(gaps) else 0.0
