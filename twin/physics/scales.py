"""Scales of a motion, from which first guesses are made; never zero, so that they can divide."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

TINY = 1e-12
"""The least scale that a motion has [m, m/s, ...]."""


def rms(values: NDArray[np.float64]) -> float:
    """Return the root mean square."""
    return max(float(np.sqrt(np.mean(np.square(values)))), TINY) if np.size(values) else TINY


def peak(values: NDArray[np.float64]) -> float:
    """Return the largest magnitude."""
    return max(float(np.max(np.abs(values))), TINY) if np.size(values) else TINY
