"""A channel's innovations: what of each sample those before it do not predict."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, signal, stats

from twin.signals.fault import FALSE_ALARM

Array = NDArray[np.float64]

ORDER = 32
"""Coefficients of the prediction: two for each mode of a structure of sixteen."""

HALF = 64
"""Innovations to either side of one that say how large they are there."""

ROUNDS = 3
OUTLYING = 3.0
"""Innovations of more standard deviations do not shape the filter (one in 370 of normal ones)."""


def prediction_error_filter(x: Array, order: int = ORDER) -> Array:
    """Return the filter 1 - a1 z^-1 - ... that leaves white innovations, (order + 1,).

    Least squares on the samples, each weighed by how large innovations are around it: a decay is
    predicted as well as a stationary motion. Blows and wrong samples are left out.

    Args:
        x: (samples,), several times ``order`` of them.
        order: of the prediction.
    """
    x = np.asarray(x, float) - np.mean(x)
    order = min(order, len(x) // 8)
    if order < 1 or not np.any(x):
        return np.array([1.0])
    past = np.lib.stride_tricks.sliding_window_view(x, order + 1)
    rows, aims = past[:, :-1][:, ::-1], past[:, -1]
    weight: Array = np.ones(len(aims))
    value: Array = np.zeros(order)
    for _ in range(ROUNDS):
        value = np.asarray(np.linalg.lstsq(rows * weight[:, None], aims * weight, rcond=None)[0])
        e = aims - rows @ value
        scale = local_scale(e)
        weight = np.asarray(np.where(np.abs(e) <= OUTLYING * scale, 1 / scale, 0.0))
    return np.concatenate([[1.0], -value])


def innovations(x: Array, taps: Array) -> Array:
    """Return the signal behind a prediction-error filter, (samples,)."""
    return np.asarray(signal.lfilter(taps, [1.0], np.asarray(x, float) - np.mean(x)))


def local_scale(e: Array) -> Array:
    """Return the standard deviation of innovations around each of them, by their median."""
    size = np.abs(e)
    scale = 1.4826 * ndimage.median_filter(size, 2 * HALF + 1, mode="reflect")
    return np.asarray(np.maximum(scale, 1e-12 * np.max(size) + 1e-300))


def noise_level(count: int) -> float:
    """Return what so many innovations over their local scale reach by chance, rarely.

    A median of 129 is worth 48 degrees of freedom: it has 0.37 of the mean's efficiency.
    """
    return -float(stats.t.ppf(FALSE_ALARM / (2 * count), 0.37 * (2 * HALF + 1)))
