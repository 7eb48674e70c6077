"""What stands between a quantity and its reading, as a small linear system."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.arrays import frozen

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Instrument:
    """s' = A s + B y + G w, reading = C s + D y for the quantities y of c channels.

    Attributes:
        D: what passes at once, (c, c).
        A, B, C: the instrument's own states, (k, k), (k, c), (c, k); none for a static one.
        G: entry of continuous white noise of unit intensity, (k, g).
        start: covariance of the states before the first sample, (k, k).
    """

    D: Array
    A: Array
    B: Array
    C: Array
    G: Array
    start: Array

    def __post_init__(self) -> None:
        for name in ("D", "A", "B", "C", "G", "start"):
            object.__setattr__(self, name, frozen(getattr(self, name), float))

    @classmethod
    def static(cls, D: Array) -> Instrument:
        """Return an instrument without states."""
        c = len(np.atleast_2d(D))
        empty = np.zeros((0, 0))
        return cls(
            np.atleast_2d(D), empty, np.zeros((0, c)), np.zeros((c, 0)), np.zeros((0, 0)), empty
        )

    @classmethod
    def of(
        cls, A: Array, B: Array, C: Array, D: float, start: Array, G: Array | None = None
    ) -> Instrument:
        """Return an instrument of one channel: A (k, k), B (k,), C (k,), start (k, k), G (k,)."""
        k = len(A)
        column = np.zeros((k, 0)) if G is None else np.reshape(G, (k, 1))
        return cls(np.array([[D]]), A, np.reshape(B, (k, 1)), np.reshape(C, (1, k)), column, start)
