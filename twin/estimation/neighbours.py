"""The gains of several systems of one shape side by side, for differences between neighbours.

The recursion is that of ``twin.estimation.kalman``; every matrix has the systems in its last axis,
(rows, columns, k), so that each product of two numbers is one of two contiguous rows: two to three
times as fast as one system after the other.
"""

# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

from collections.abc import Sequence

import numba
import numpy as np
from numpy.typing import NDArray

from twin.estimation.kalman import EquivalentLinear, matrices_of
from twin.estimation.system import Noise, Sampled

Array = NDArray[np.float64]


def neighbouring_gains(
    systems: Sequence[tuple[Sampled, Noise]],
    count: int,
    equivalent: EquivalentLinear | None,
    missing: NDArray[np.bool_] | None = None,
) -> tuple[Array, Array]:
    """Return corrections of state and held disturbances, and the innovations' covariances.

    Args:
        systems: k sampled systems of one shape with their noise levels.
        count: samples before the stationary gain takes over.
        equivalent: what laws add to each of them, if there are laws.
        missing: outputs that were not measured in the first samples, (samples, m).

    Returns:
        Corrections (count + 1, n + w, m, k) and covariances (count + 1, m, m, k), the last ones
        stationary.

    Raises:
        NoLikelihoodError: a Riccati equation has no stationary solution.
    """
    found = [matrices_of(plant, noise, equivalent) for plant, noise in systems]
    A, C, W, V, Q, R, P = (np.stack(kind, axis=-1) for kind in zip(*found, strict=True))
    start = np.stack([noise.start for _, noise in systems], axis=-1)
    levels = np.stack([noise.held for _, noise in systems], axis=-1)
    n, m, w, k = len(A), len(C), W.shape[1], A.shape[2]
    state, held = np.zeros((count + 1, n, m, k)), np.zeros((count + 1, w, m, k))
    innovation = np.zeros((count + 1, m, m, k))
    gaps = np.zeros((0, m), bool) if missing is None else np.ascontiguousarray(missing)
    at, kicks = systems[0][1].in_order()
    _sequences(A, C, W, V, Q, R, start, P, gaps, at, kicks, state, held, innovation)
    return np.concatenate([state, held * levels[:, None]], axis=1), innovation


@numba.njit(nogil=True, cache=True)
def _sequences(
    A, C, W, V, Q, R, start, stationary, missing, at, kicks, state, held, innovation
):  # fmt: skip
    n, m, k = len(A), len(C), A.shape[2]
    every_C, every_V, every_R = C, V, R
    P, PC, AP = start.copy(), np.zeros((n, m, k)), np.zeros((n, n, k))
    K, KS, work = np.zeros((n, m, k)), np.zeros((n, m, k)), np.zeros((m, m, k))
    inverse = np.zeros((m, m, k))
    rows = np.zeros((m, n, k))
    last, kicked = len(state) - 1, 0
    for t in range(last + 1):
        S = innovation[t]
        if kicked < len(at) and at[kicked] == t:
            P += kicks[kicked].reshape(n, n, 1)
            kicked += 1
        if t == last:
            P[:] = stationary
        if t <= len(missing):
            C, V, R = every_C.copy(), every_V.copy(), every_R.copy()
            for o in range(m if t < len(missing) else 0):
                if missing[t, o]:
                    C[o], V[o], R[o, o] = 0.0, 0.0, 1.0
            VT = _transposed(V)
        PC[:], S[:] = 0.0, R
        _add_product(PC, P, C, n)
        _transpose(PC, rows)
        _add_product(S, C, rows, m)
        _add_product(S, V, V, m)
        _invert(S, work, inverse)
        _add_product(state[t], PC, inverse, n)
        _add_product(held[t], VT, inverse, n)
        if t == last:
            break
        K[:], KS[:], AP[:] = 0.0, 0.0, 0.0
        _transpose(state[t], rows)
        _add_product(K, A, rows, n)
        _add_product(K, W, _transposed(held[t]), n)
        _add_product(AP, A, P, n)
        _add_product(KS, K, S, n)
        KS *= -1.0
        P[:] = Q
        _add_product(P, AP, A, -1)
        _add_product(P, KS, K, -1)
        for i in range(n):
            for l in range(i):  # noqa: E741
                P[l, i] = P[i, l]


@numba.njit(nogil=True, cache=True)
def _transpose(M, out):
    for i in range(M.shape[0]):
        for l in range(M.shape[1]):  # noqa: E741
            out[l, i] = M[i, l]


@numba.njit(nogil=True, cache=True)
def _transposed(M):
    out = np.zeros((M.shape[1], M.shape[0], M.shape[2]))
    _transpose(M, out)
    return out


@numba.njit(nogil=True, cache=True)
def _add_product(out, X, Y, rows):
    """Add X Y^T to out, (rows, columns, k); where rows is -1 only up to its diagonal."""
    for i in range(X.shape[0]):
        for l in range(i + 1 if rows < 0 else len(Y)):  # noqa: E741
            _add_along(out[i, l], X[i], Y[l])


@numba.njit(nogil=True, cache=True, forceinline=True)
def _add_along(out, X, Y):
    """Add sum_s X[s] Y[s] to out, (k,); four at a time: out is loaded and stored once for them."""
    count = len(X)
    whole = count - count % 4
    for s in range(0, whole, 4):
        for a in range(len(out)):
            out[a] += (
                X[s, a] * Y[s, a]
                + X[s + 1, a] * Y[s + 1, a]
                + X[s + 2, a] * Y[s + 2, a]
                + X[s + 3, a] * Y[s + 3, a]
            )
    for s in range(whole, count):
        for a in range(len(out)):
            out[a] += X[s, a] * Y[s, a]


@numba.njit(nogil=True, cache=True)
def _invert(S, work, out):
    """Fill S^-1, (m, m, k), by elimination; a positive matrix needs no pivots."""
    m = len(S)
    factor = np.zeros(S.shape[2])
    work[:], out[:] = S, 0.0
    for j in range(m):
        out[j, j] = 1.0
    for j in range(m):
        factor[:] = 1.0 / work[j, j]
        for l in range(m):  # noqa: E741
            for a in range(len(factor)):
                work[j, l, a] *= factor[a]
                out[j, l, a] *= factor[a]
        for i in range(m):
            if i != j:
                factor[:] = work[i, j]
                for l in range(m):  # noqa: E741
                    for a in range(len(factor)):
                        work[i, l, a] -= factor[a] * work[j, l, a]
                        out[i, l, a] -= factor[a] * out[j, l, a]
