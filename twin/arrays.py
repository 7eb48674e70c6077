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


def filled(y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return samples with what is left out interpolated, (samples, m)."""
    out = np.array(y)
    for column in out.T:
        gap = np.isnan(column)
        if gap.any() and not gap.all():
            at = np.arange(len(column))
            column[gap] = np.interp(at[gap], at[~gap], column[~gap])
    return out
