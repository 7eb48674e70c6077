"""Channels that stand in another order than the model's, as floors numbered from the roof down.

In its fundamental mode every chain moves the more against the ground the higher up, whatever its
numbers: the order of the amplitudes is that of the places. Where the outputs' common motion grows
the other way, the columns of the file are named the other way.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, signal

from twin.diagnosis.sizes import CALIBRATED
from twin.model.linear import LinearModel

Array = NDArray[np.float64]

CORNER_ORDER = 4
"""Of the low-pass filter that leaves the fundamental mode (Butterworth)."""


def read_order(model: LinearModel, u: Array, y: Array, rate_hz: float) -> tuple[int, ...]:
    """Return which column of the outputs each of the model's accelerations is.

    The columns as they stand unless they contradict the fundamental mode altogether: two that are
    exchanged are a fault of channels that is found, or not, like any other.

    Args:
        model: the nominal twin; all its outputs are accelerations of a base that shakes.
        u: the ground's motion, (samples, r).
        y: outputs in the order of their names, (samples, m).
        rate_hz: samples per second.
    """
    as_they_stand = tuple(range(y.shape[1]))
    if y.shape[1] < 2:
        return as_they_stand
    y = y - u @ model.Cu.T
    values, shapes = linalg.eigh(model.K, model.M)
    corner = np.sqrt(float(np.sqrt(values[0] * values[min(1, len(values) - 1)]))) / (2 * np.pi)
    if values[0] > 0 and corner < 0.4 * rate_hz:
        sos = signal.butter(CORNER_ORDER, corner, fs=rate_hz, output="sos")
        y = signal.sosfiltfilt(sos, y - y.mean(axis=0), axis=0)
    expected = model.Ca @ shapes[:, 0]
    if np.any(expected * np.sign(expected.sum()) <= CALIBRATED * np.abs(expected).max()):
        return as_they_stand  # not all accelerations of one chain along one axis
    seen = linalg.svd(y, full_matrices=False)[2][0]
    seen = seen * np.sign(seen.sum()) / np.linalg.norm(seen)
    expected = expected * np.sign(expected.sum()) / np.linalg.norm(expected)
    if np.ptp(seen) < CALIBRATED * np.abs(seen).max() * np.sqrt(y.shape[1]):
        return as_they_stand
    if float((seen - seen.mean()) @ (expected - expected.mean())) >= 0:
        return as_they_stand
    order = np.empty(y.shape[1], int)
    order[np.argsort(expected)] = np.argsort(seen)
    return tuple(int(i) for i in order)


def in_words(name: str, outputs: tuple[str, ...], order: tuple[int, ...]) -> str:
    """Say which column is read as which output."""
    pairs = ", ".join(f"{outputs[i]} as {n}" for n, i in zip(outputs, order, strict=True))
    return (
        f"{name}: the accelerations grow the other way than the model's fundamental mode, so the "
        f"columns are taken as named in another order: {pairs}"
    )
