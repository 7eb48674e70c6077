"""Mains hum in a channel, by Thomson's test for a line."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import signal, stats

from twin.signals.fault import FALSE_ALARM, Fault

Array = NDArray[np.float64]

MAINS_HZ = (50.0, 60.0)
WANDER = 2e-3
"""Share by which the frequency of the mains strays."""

HARMONICS = 3
TAPERS, BANDWIDTH = 7, 4.0
"""Slepian tapers and their half bandwidth over the resolution (Thomson 1982)."""


def hum(x: Array, rate_hz: float) -> Fault | None:
    """Return whether a channel carries the mains: Thomson's test for a line at its harmonics.

    Source: Thomson 1982, Proceedings of the IEEE 70, section XIII. The record is tested as a whole
    and in halves, as a blow in one of them covers the line. Where a rate is too low for the
    mains the line is looked for where it folds to.
    """
    x = np.asarray(x, float)
    half = len(x) // 2
    found = [f for part in (x, x[:half], x[half:]) if (f := _line(part, rate_hz)) is not None]
    if not found:
        return None
    _, frequency, amplitude = max(found)
    words = f"a line of the mains at {frequency:.4g} Hz with amplitude {amplitude:.3g}"
    return Fault("hum", amplitude, (), words, frequency)


def _line(x: Array, rate_hz: float) -> tuple[float, float, float] | None:
    """Return ratio, frequency [Hz] and amplitude of the strongest line of the mains, or None."""
    n = len(x)
    if n < 64 or not np.ptp(x):
        return None
    windows = tapers(n, BANDWIDTH, TAPERS)
    fine = 2 ** int(np.ceil(np.log2(4 * n)))
    spectra = np.fft.rfft(windows * (x - np.mean(x)), fine, axis=1)
    weight = windows.sum(axis=1)
    mean = weight @ spectra / (weight @ weight)
    rest = np.sum(np.abs(spectra - weight[:, None] * mean) ** 2, axis=0)
    ratio = (TAPERS - 1) * np.abs(mean) ** 2 * (weight @ weight) / np.maximum(rest, 1e-300)
    frequency = np.fft.rfftfreq(fine, 1 / rate_hz)
    lowest = BANDWIDTH * rate_hz / n
    best: tuple[float, float, float] | None = None
    for mains in MAINS_HZ:
        for order in range(1, HARMONICS + 1):
            folded = abs((order * mains + rate_hz / 2) % rate_hz - rate_hz / 2)
            near = np.abs(frequency - folded) <= WANDER * order * mains
            near &= (frequency > lowest) & (frequency < rate_hz / 2 - lowest)
            tests = 3 * np.count_nonzero(near) * len(MAINS_HZ) * HARMONICS
            if not tests:
                continue
            k = int(np.argmax(np.where(near, ratio, 0)))
            limit = stats.f.isf(FALSE_ALARM / tests, 2, 2 * TAPERS - 2)
            if ratio[k] > limit and (best is None or ratio[k] > best[0]):
                best = (float(ratio[k]), float(frequency[k]), float(2 * np.abs(mean[k])))
    return best


@lru_cache(maxsize=8)
def tapers(samples: int, bandwidth: float, count: int) -> Array:
    """Return Slepian tapers, (count, samples); the channels of a recording share them."""
    return np.asarray(signal.windows.dpss(samples, bandwidth, count))
