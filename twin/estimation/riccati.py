"""Riccati's and Lyapunov's equations of sampled systems, by doubling."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DOUBLINGS = 60
"""At most; each squares the number of samples that the covariance has settled over."""

SETTLED = 1e-13
"""Largest step, as a share of the largest covariance, with which the doubling has converged."""


@numba.njit(nogil=True, cache=True)
def stationary(A, C, Q, R, S):  # type: ignore[no-untyped-def]
    """Return the stationary covariance by doubling (Chu, Fan, Lin and Wang 2004), (n, n).

    It stays exact where the Schur method cannot order its eigenvalues: oscillators that hardly
    decay under noise that is hardly there. All are NaN where it does not converge.
    """
    inverse = np.linalg.inv(R)
    gain = S @ inverse
    a = np.ascontiguousarray((A - gain @ C).T)
    g = np.ascontiguousarray(C.T) @ inverse @ C
    h = Q - gain @ np.ascontiguousarray(S.T)
    n = len(A)
    eye = np.eye(n)
    for _ in range(DOUBLINGS):
        w = np.linalg.solve(eye + g @ h, np.hstack((a, g)))
        wa, wg = np.ascontiguousarray(w[:, :n]), np.ascontiguousarray(w[:, n:])
        across = np.ascontiguousarray(a.T)
        step = across @ h @ wa
        g = g + a @ wg @ across
        a = a @ wa
        h = h + step
        h, g = (h + h.T) / 2, (g + g.T) / 2
        size = np.abs(h).max()
        if not np.isfinite(size):
            break
        if np.abs(step).max() <= SETTLED * size:
            return h
    return np.full((n, n), np.nan)


def summed(F: Array, terms: Array, count: int) -> Array:
    """Return the sum of F^k M F^kT over k < count by doubling, of matrices (..., n, n).

    Where F does not decay it may not be finite.
    """
    total, before, power = np.zeros_like(terms), np.eye(F.shape[-1]), F
    with np.errstate(all="ignore"):
        while count:
            more = power @ terms @ power.swapaxes(-1, -2)
            if np.all(_largest(more) <= SETTLED * _largest(terms)):
                return total + before @ terms @ before.swapaxes(-1, -2)
            if count % 2:
                total = total + before @ terms @ before.swapaxes(-1, -2)
                before = before @ power
            terms, power, count = terms + more, power @ power, count // 2
    return total


def _largest(matrices: Array) -> Array:
    return np.max(np.abs(matrices), axis=(-2, -1))
