"""Read-only copies, so that results cannot be changed behind their owner's back."""

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
