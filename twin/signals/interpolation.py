"""Samples that are missing, from an autoregressive model of the rest (Janssen et al. 1986)."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.sparse import diags
from scipy.sparse.linalg import spsolve

Array = NDArray[np.float64]

ORDER = 24
"""Order of the model: two for each resonance, and a dozen are in a band."""

EACH = 4
"""Stretches without a gap that there must be for each coefficient."""


def interpolated(x: Array, missing: NDArray[np.bool_], order: int = ORDER) -> Array | None:
    """Return a signal whose missing samples make the model's errors least; None where none is.

    A steady tone of any frequency is continued as it is, a random motion as its resonances ring.

    Args:
        x: the signal, (samples,).
        missing: which samples are not to be used, (samples,).
        order: of the model.

    Source: Janssen, Veldhuis and Vries 1986, IEEE Transactions on Acoustics, Speech, and Signal
    Processing 34(2).
    """
    if len(x) <= order or not missing.any():
        return None
    whole = ~np.any(sliding_window_view(missing, order + 1), axis=1)
    if np.count_nonzero(whole) < EACH * order:
        return None
    windows = sliding_window_view(x, order + 1)[whole]
    past, *_ = np.linalg.lstsq(windows[:, :-1], windows[:, -1], rcond=None)
    weights = np.append(-past, 1.0)
    rows = len(x) - order
    errors = diags(weights, range(order + 1), shape=(rows, len(x))).tocsc()
    free = errors[:, missing]
    normal = (free.T @ free).tocsc()
    out = np.array(x, float)
    out[missing] = spsolve(normal, -(free.T @ (errors @ np.where(missing, 0.0, x))))
    return out if np.all(np.isfinite(out)) else None
