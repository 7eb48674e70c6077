"""The noise of one channel from its own samples."""

from __future__ import annotations

from math import comb

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ORDER = 6
"""Of the differences: 7 Hz sampled at 256 Hz is weakened 4e-5 times, white noise grows 30 times."""


def noise_floor(samples: Array) -> float:
    """Return the standard deviation of the white noise in a smooth signal.

    The sixth differences of a signal sampled much faster than it moves are those of its noise; the
    median of their magnitudes is not disturbed by hits.

    Args:
        samples: (samples,), at least seven.
    """
    if len(samples) <= ORDER:
        return 0.0
    differences = np.diff(samples, ORDER)
    gain = np.sqrt(sum(comb(ORDER, k) ** 2 for k in range(ORDER + 1)))
    return float(1.4826 * np.median(np.abs(differences)) / gain)
