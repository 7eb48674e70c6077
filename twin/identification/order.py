"""The order of a realization from the singular values of its Hankel matrix."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CLEAR_GAP = 2.0
LARGEST_ORDER = 40
ROUNDING = 1e-9


def order_from_singular_values(singular_values: Array, largest: int = LARGEST_ORDER) -> int | None:
    """Return the order after which the singular values fall by a clear gap, or None.

    The last drop by a factor of two or more counts: what noise leaves behind falls slowly, while
    the modes may differ in strength by any factor among themselves. Values at rounding level
    relative to the first are zero. Vibrating modes come in pairs, so the order is even.

    Args:
        singular_values: largest first.
        largest: highest order considered.
    """
    sigma = np.asarray(singular_values, float)
    if not len(sigma) or sigma[0] <= 0:
        return None
    rank = int(np.sum(sigma > ROUNDING * sigma[0]))
    if rank <= largest and rank < len(sigma) and rank % 2 == 0:
        return rank
    top = min(largest, len(sigma) - 1, rank - 1)
    drops = sigma[:top] / sigma[1 : top + 1]
    clear = [n for n in range(2, top + 1, 2) if drops[n - 1] >= CLEAR_GAP]
    return clear[-1] if clear else None
