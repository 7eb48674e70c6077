"""Small helpers for arrays: read-only copies, so that results cannot be changed; gaps filled."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


def frozen(values: ArrayLike, dtype: Any = None) -> NDArray[Any]:
    """Return a read-only copy of ``values`` as an array (floats, unless ``values`` is complex)."""
    array = np.array(values, dtype=dtype)
    if dtype is None and array.dtype.kind in "iub":
        array = array.astype(float)
    array.setflags(write=False)
    return array


def rms_of(y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the RMS of the columns of samples, (m,); 0 of one that is left out whole."""
    there = ~np.isnan(y)
    squares = np.where(there, y, 0.0) ** 2
    return np.asarray(np.sqrt(squares.sum(axis=0) / np.maximum(there.sum(axis=0), 1)))


def filled(y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return samples with what is left out interpolated, (samples, m)."""
    out = np.array(y)
    for column in out.T:
        gap = np.isnan(column)
        if gap.any() and not gap.all():
            at = np.arange(len(column))
            column[gap] = np.interp(at[gap], at[~gap], column[~gap])
    return out
