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


def plain(values: ArrayLike) -> NDArray[np.float64]:
    """Return an array in rows that may be written to: the same, or a copy where it is none.

    A loop is compiled for each kind of array that it is given, read-only ones and others, which
    takes half a minute where the loop is long.
    """
    return np.require(values, dtype=float, requirements=("C", "W"))


def rms_of(y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the RMS of the columns of samples, (m,); 0 of one that is left out whole."""
    there = ~np.isnan(y)
    squares = np.where(there, y, 0.0) ** 2
    return np.asarray(np.sqrt(squares.sum(axis=0) / np.maximum(there.sum(axis=0), 1)))


def strongest(x: NDArray[np.float64], longest: int) -> slice:
    """Return the part of so many samples at most in which columns, (samples, c), have most power.

    That of each counts as a share of what it varies by; what is left out, NaN, counts nothing.
    """
    if len(x) <= longest:
        return slice(0, len(x))
    varies = rms_of(x - np.nan_to_num(np.nanmean(x, axis=0)))
    power = np.nan_to_num(x / np.maximum(varies, 1e-300)) ** 2
    total = np.concatenate([[0.0], np.cumsum(power.sum(axis=1))])
    first = int(np.argmax(total[longest:] - total[:-longest]))
    return slice(first, first + longest)


def filled(y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return samples with what is left out interpolated, (samples, m)."""
    out = np.array(y)
    for column in out.T:
        gap = np.isnan(column)
        if gap.any() and not gap.all():
            at = np.arange(len(column))
            column[gap] = np.interp(at[gap], at[~gap], column[~gap])
    return out
