"""Shift a band-limited signal in time by any fraction of a sample."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

Array = NDArray[np.float64]

MARGIN = 256
"""Samples by which a signal is continued at either end."""


def later(signal: Array, delay_s: float, rate_hz: float) -> Array:
    """Return x(t - delay) at the samples of x(t), (samples,).

    The signal is taken as band-limited below half the sampling rate and is continued at its ends
    by its odd reflection: over |delay| at one end, and a few samples at the other, it is a guess.
    """
    x = np.asarray(signal, float)
    if delay_s == 0 or len(x) < 2:
        return x.copy()
    wanted = MARGIN + 2 * int(np.ceil(abs(delay_s) * rate_hz))
    pad = min(wanted, len(x) - 1)
    longer = np.concatenate([2 * x[0] - x[pad:0:-1], x, 2 * x[-1] - x[-2 : -pad - 2 : -1]])
    # From one end back to the other without a step, where the transform closes the circle.
    length = next_fast_len(len(longer) + 2 * wanted, real=True)
    gap = length - len(longer)
    fade = 0.5 + 0.5 * np.cos(np.pi * (np.arange(gap) + 1) / (gap + 1))
    closed = np.concatenate([longer, longer[-1] * fade + longer[0] * (1 - fade)])
    spectrum = rfft(closed) * np.exp(-2j * np.pi * rfftfreq(length, 1 / rate_hz) * delay_s)
    return np.asarray(irfft(spectrum, length)[pad : pad + len(x)])
