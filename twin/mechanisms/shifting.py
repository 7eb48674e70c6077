"""Shift, stretch and filter a band-limited signal between its samples."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.interpolate import CubicSpline

Array = NDArray[np.float64]

FINER = 4
"""Samples to a sample from which a cubic is good to 1e-4 up to 0.8 of half the sampling rate."""

MARGIN = 256
"""Samples by which a signal is continued at either end."""


def later(signal: Array, delay_s: float, rate_hz: float) -> Array:
    """Return x(t - delay) at the samples of x(t), (samples,).

    The signal is taken as band-limited below half the sampling rate and is continued at its ends
    by its odd reflection: over |delay| at one end, and a few samples at the other, it is a guess.
    """
    if delay_s == 0 or len(signal) < 2:
        return np.array(signal, float)
    shifted = partial(_delay, delay_s)
    return through(signal, shifted, rate_hz, abs(delay_s))


def _delay(delay_s: float, frequency: Array) -> NDArray[np.complex128]:
    return np.asarray(np.exp(-2j * np.pi * frequency * delay_s))


def through(
    signal: Array,
    response: Callable[[Array], NDArray[np.complex128]],
    rate_hz: float,
    reach_s: float,
) -> Array:
    """Return a signal behind a filter, (samples,), with no transient where it begins.

    Args:
        signal: band-limited below half the sampling rate, (samples,).
        response: frequencies [Hz] -> complex gain.
        rate_hz: samples per second.
        reach_s: how long the filter remembers, or looks ahead [s]. Over it, and a few samples more,
            the signal is continued at its ends by its odd reflection.
    """
    x = np.asarray(signal, float)
    wanted = MARGIN + 2 * int(np.ceil(reach_s * rate_hz))
    pad = min(wanted, len(x) - 1)
    longer = np.concatenate([2 * x[0] - x[pad:0:-1], x, 2 * x[-1] - x[-2 : -pad - 2 : -1]])
    # From one end back to the other without a step, where the transform closes the circle.
    length = next_fast_len(len(longer) + 2 * wanted, real=True)
    gap = length - len(longer)
    fade = 0.5 + 0.5 * np.cos(np.pi * (np.arange(gap) + 1) / (gap + 1))
    closed = np.concatenate([longer, longer[-1] * fade + longer[0] * (1 - fade)])
    spectrum = rfft(closed) * response(rfftfreq(length, 1 / rate_hz))
    return np.asarray(irfft(spectrum, length)[pad : pad + len(x)])


def stretched(signal: Array, rate_hz: float, share: float) -> Array:
    """Return x(t (1 + share)) at the samples of x(t), (samples,).

    Between samples it is a cubic through the band-limited signal at ``FINER`` times the rate;
    beyond the last sample it is that sample.
    """
    x = np.asarray(signal, float)
    if share == 0 or len(x) < 4:
        return x.copy()
    fine = np.ravel([later(x, -k / FINER / rate_hz, rate_hz) for k in range(FINER)], order="F")
    wanted = np.arange(len(x)) * (1 + share) * FINER
    curve = CubicSpline(np.arange(len(fine)), fine)
    return np.asarray(curve(np.clip(wanted, 0, len(fine) - 1)))
