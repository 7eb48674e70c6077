"""Coordinates in which modes do not move one another, where a step costs n numbers and not n^2.

With the real and imaginary parts of the eigenvectors of A as columns of T, x = T q turns A into
blocks of two oscillating and of one decaying state (real modal form), and any function of A too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import matrix_balance

Array = NDArray[np.float64]

WORST = 1e6
"""Condition number of T beyond which rounding (1e-16) would be seen (1e-10): of modes that are
nearly one, as two of a rigid body, which no such coordinates tell apart."""


@dataclass(frozen=True)
class Decoupled:
    """Coordinates q of the states x = T q.

    Attributes:
        to: T, (n, n).
        back: its inverse, (n, n).
        near: the first state that moves each state, and that behind the last one, (n, 2).
    """

    to: Array
    back: Array
    near: NDArray[np.int64]

    def of_step(self, step: Array) -> Array:
        """Return what steps x by x and others, (n, n + k), or derivatives of it, for q."""
        n = len(self.to)
        turned = np.tensordot(self.back, step, 1)
        if step.ndim == 2:
            turned[:, :n] = turned[:, :n] @ self.to
        else:
            turned[:, :n] = np.tensordot(turned[:, :n], self.to, (1, 0)).swapaxes(1, 2)
        return np.ascontiguousarray(turned)


def decoupled(A: Array) -> Decoupled:
    """Return coordinates in which the modes of x' = A x, (n, n), do not move one another.

    Where modes are so near to one another that these are not well defined, the states themselves.
    """
    n = len(A)
    itself = Decoupled(np.eye(n), np.eye(n), np.tile([0, n], (n, 1)))
    if not (n and np.all(np.isfinite(A))):
        return itself
    balanced, (scale, _) = matrix_balance(A, permute=False, separate=True)  # units do not count
    values, vectors = np.linalg.eig(balanced)
    T, near, i = np.empty((n, n)), np.empty((n, 2), np.int64), 0
    while i < n:
        width = 1 if values[i].imag == 0.0 else 2
        T[:, i : i + width] = np.column_stack([vectors[:, i].real, vectors[:, i].imag])[:, :width]
        near[i : i + width] = i, i + width
        i += width
    if not np.linalg.cond(T) < WORST:
        return itself
    T *= scale[:, None]
    return Decoupled(T, np.asarray(np.linalg.inv(T), float), near)
