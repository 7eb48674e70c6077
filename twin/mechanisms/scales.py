"""Scales of a motion, from which first guesses are made; never zero, so that they can divide."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

TINY = 1e-12
"""The least scale that a motion has [m, m/s, ...]."""

TAILS = (0.01, 0.02, 0.05, 0.1)
NEAR = 0.05
PILED = 1.5
"""Readings pile up at the end of a range where, so near to the one that a tail cuts off, there are
more of them than the tail holds, so many times. Gaussian readings reach 0.62 times."""


def rms(values: NDArray[np.float64]) -> float:
    """Return the root mean square."""
    return max(float(np.sqrt(np.mean(np.square(values)))), TINY) if np.size(values) else TINY


def peak(values: NDArray[np.float64]) -> float:
    """Return the largest magnitude."""
    return max(float(np.max(np.abs(values))), TINY) if np.size(values) else TINY


def range_ends(values: NDArray[np.float64]) -> tuple[float, float] | None:
    """Return where readings pile up at both ends of a channel's range, None where they do not."""
    for tail in TAILS:
        low, high = np.quantile(values, [tail, 1 - tail])
        near = NEAR * (high - low) / 2
        ends = [values[np.abs(values - end) < near] for end in (low, high)]
        if min(len(end) for end in ends) > PILED * tail * len(values):
            return float(np.median(ends[0])), float(np.median(ends[1]))
    return None
