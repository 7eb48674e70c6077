"""The gains of the one-step predictor, from an unknown state to the stationary filter."""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from twin.arrays import plain
from twin.errors import NoLikelihoodError
from twin.estimation.products import add_product
from twin.estimation.riccati import stationary
from twin.estimation.system import Noise, Sampled

Array = NDArray[np.float64]

SAME = 1e-3
"""Share of its stationary value within which the innovations' covariance counts as settled."""

LONGEST_START = 256
"""Samples of time-varying gains at most; a mode that has not settled by then hardly decays."""


@dataclass(frozen=True)
class Gains:
    """Gains of the predictor, sample by sample to begin with, the last one for all that follow.

    Attributes:
        state: correction of the state, (t, n, m).
        held: estimate of the disturbances held over the sample, (t, w, m).
        innovation: covariance of the innovations, (t, m, m).
        predicted: stationary covariance of the predicted state, (n, n).
    """

    state: Array
    held: Array
    innovation: Array
    predicted: Array


def open_loop(gain: Gains) -> Gains:
    """Return gains that listen to nothing: the predictor is then a simulation."""
    return Gains(0 * gain.state[-1:], 0 * gain.held[-1:], gain.innovation, gain.predicted)


def silent(plant: Sampled) -> Gains:
    """Return gains of no filter at all, with which the predictor is a simulation."""
    (n, held), m = plant.W.shape, len(plant.system.C)
    return Gains(np.zeros((1, n, m)), np.zeros((1, held, m)), np.eye(m)[None], np.zeros((n, n)))


@dataclass(frozen=True)
class EquivalentLinear:
    """What laws make of a linear system on the average of a motion (statistical linearisation).

    Attributes:
        whole: added to what a sample does to the state, (n, n).
        C: added to the outputs, (m, n).

    Source: Roberts and Spanos 1990, Random Vibration and Statistical Linearization.
    """

    whole: Array
    C: Array


def gains(
    sampled: Sampled,
    noise: Noise,
    first: int | None = None,
    equivalent: EquivalentLinear | None = None,
    missing: NDArray[np.bool_] | None = None,
) -> Gains:
    """Return the gains (Kalman 1960; held disturbances correlate state and output noise).

    Args:
        sampled: the system.
        noise: levels, and the covariance of the state before the first sample.
        first: samples before the stationary gain takes over; as many as it needs without.
        equivalent: what laws add to the linear system, if there are laws.
        missing: outputs that were not measured, to the last gap, (samples, m); there are then
            gains for every sample to that (Jones 1980), and a missing output's innovation has
            variance 1.

    Raises:
        NoLikelihoodError: the Riccati equation has no stationary solution, or outputs are without
            noise.
    """
    A, C, W, V, Q, R, P = matrices_of(sampled, noise, equivalent)
    try:
        state, held, innovation = _sequence(
            A, C, W, V, Q, R, noise.start, P,
            -1 if first is None else first,
            np.zeros((0, 0), bool) if missing is None else np.ascontiguousarray(missing),
            *noise.in_order(),
        )  # fmt: skip
    except ZeroDivisionError:
        raise NoLikelihoodError("the innovations' covariance is singular") from None
    return Gains(state, noise.held[:, None] * held, innovation, P)


def start_covariances(
    sampled: Sampled, noise: Noise, gain: Gains, equivalent: EquivalentLinear | None
) -> Array:
    """Return the covariance of the state before each sample until its gains settle, (t, n, n).

    ``LONGEST_START`` at most. Arguments are those of ``gains``, and what it returned.
    """
    A = sampled.whole if equivalent is None else sampled.whole + equivalent.whole
    W = plain(sampled.entry)
    spread = W * noise.held
    first = min(len(gain.state) - 1, LONGEST_START)
    return np.asarray(
        _covariances(
            plain(A), W, spread @ spread.T + sampled.Q, noise.start,
            gain.state[:first], gain.held[:first], gain.innovation[:first],
        )
    )  # fmt: skip


@numba.njit(nogil=True, cache=True)
def _covariances(A, W, Q, start, state, held, innovation):  # type: ignore[no-untyped-def]
    samples, n, m = state.shape
    out = np.zeros((samples, n, n))
    AP, K, KT, KS = np.zeros((n, n)), np.zeros((n, m)), np.zeros((m, n)), np.zeros((n, m))
    AT, P = A.T.copy(), start.copy()
    for k in range(samples):
        out[k] = P
        _propagate(A, AT, W, Q, P, state[k], held[k], innovation[k], AP, K, KT, KS)
    return out


def matrices_of(
    sampled: Sampled, noise: Noise, equivalent: EquivalentLinear | None = None
) -> tuple[Array, Array, Array, Array, Array, Array, Array]:
    """Return A, C, W and V of unit disturbances, Q, R, and the stationary covariance.

    Args:
        sampled: the system.
        noise: levels.
        equivalent: what laws add to the linear system, if there are laws.

    Raises:
        NoLikelihoodError: the Riccati equation has no stationary solution.
    """
    A, C, W, V, Q, R = linear_of(sampled, noise, equivalent)
    Q = W @ W.T + Q
    P = stationary(A, C, Q, R + V @ V.T, W @ V.T)
    if not np.all(np.isfinite(P)):
        raise NoLikelihoodError("the Riccati equation has no stationary solution")
    return A, C, W, V, Q, R, P


def linear_of(
    sampled: Sampled, noise: Noise, equivalent: EquivalentLinear | None = None
) -> tuple[Array, Array, Array, Array, Array, Array]:
    """Return A, C, W and V of unit disturbances, Q of the continuous noises alone, and R."""
    system = sampled.system
    A, C = sampled.whole, system.C
    if equivalent is not None:
        A, C = A + equivalent.whole, C + equivalent.C
    W, V = sampled.entry * noise.held, system.V * noise.held
    return plain(A), plain(C), plain(W), plain(V), sampled.Q, np.diag(noise.output**2)


@numba.njit(nogil=True, cache=True)
def _update(C, V, R, P):  # type: ignore[no-untyped-def]
    n, m, w = P.shape[0], C.shape[0], V.shape[1]
    state, held, S = np.zeros((n, m)), np.zeros((w, m)), np.zeros((m, m))
    PC, inverse = np.zeros((n, m)), np.zeros((m, m))
    _correct(C, C.T.copy(), V, V.T.copy(), R, P, PC, state, held, S, inverse)
    return state, held, S


@numba.njit(nogil=True, cache=True)
def _correct(C, CT, V, VT, R, P, PC, state, held, S, inverse):  # type: ignore[no-untyped-def]
    """Fill gains and the innovations' covariance; loops, for matrices so small cost by the call.

    Transposes come as matrices of their own: rows that are contiguous are multiplied four at once.
    """
    n, m, w = P.shape[0], C.shape[0], V.shape[1]
    PC[:], S[:], state[:], held[:] = 0.0, R, 0.0, 0.0
    add_product(PC, P, 0, CT, n)
    add_product(S, C, 0, PC, n)
    add_product(S, V, 0, VT, w)
    _invert(S, inverse)
    add_product(state, PC, 0, inverse, m)
    add_product(held, VT, 0, inverse, m)


@numba.njit(nogil=True, cache=True)
def _invert(S, out):  # type: ignore[no-untyped-def]
    """Fill S^-1 by elimination; a positive matrix needs no pivots."""
    m = len(S)
    work = S.copy()
    out[:] = 0.0
    for j in range(m):
        out[j, j] = 1.0
    for j in range(m):
        scale = 1.0 / work[j, j]
        for l in range(m):  # noqa: E741
            work[j, l] *= scale
            out[j, l] *= scale
        for i in range(m):
            g = work[i, j]
            if i != j and g != 0.0:
                for l in range(m):  # noqa: E741
                    work[i, l] -= g * work[j, l]
                    out[i, l] -= g * out[j, l]


@numba.njit(nogil=True, cache=True)
def _propagate(A, AT, W, Q, P, state, held, S, AP, K, KT, KS):  # type: ignore[no-untyped-def]
    """Replace P by A P A^T + Q - K S K^T with K = A state + W held."""
    n, m, w = A.shape[0], S.shape[0], W.shape[1]
    K[:], AP[:], KS[:] = 0.0, 0.0, 0.0
    add_product(K, A, 0, state, n)
    add_product(K, W, 0, held, w)
    add_product(AP, A, 0, P, n)
    add_product(KS, K, 0, S, m)
    for i in range(n):
        for j in range(m):
            KT[j, i] = -K[i, j]
    P[:] = Q
    add_product(P, AP, 0, AT, n)
    add_product(P, KS, 0, KT, m)
    for i in range(n):
        for l in range(i):  # noqa: E741
            P[i, l] = P[l, i] = 0.5 * (P[i, l] + P[l, i])


@numba.njit(nogil=True, cache=True)
def _sequence(A, C, W, V, Q, R, start, stationary, first, missing, at, kicks):  # type: ignore[no-untyped-def]
    last_change = len(missing)
    if len(at) and at[-1] > last_change:
        last_change = at[-1]
    most = last_change + (LONGEST_START if first < 0 else first)
    n, m, w = A.shape[0], C.shape[0], W.shape[1]
    state = np.zeros((most + 1, n, m))
    held = np.zeros((most + 1, w, m))
    innovation = np.zeros((most + 1, m, m))
    PC, inverse = np.zeros((n, m)), np.zeros((m, m))
    AP, K, KT, KS = np.zeros((n, n)), np.zeros((n, m)), np.zeros((m, n)), np.zeros((n, m))
    AT, CT, VT = A.T.copy(), C.T.copy(), V.T.copy()
    last_state, last_held, last = _update(C, V, R, stationary)
    size = np.abs(last).max()
    P = start.copy()
    used, settled, kicked = 0, False, 0
    for k in range(most):
        gap = False
        if kicked < len(at) and at[kicked] == k:
            P[:] = (stationary if settled else P) + kicks[kicked]
            settled, kicked = False, kicked + 1
        if k < len(missing):
            for o in range(m):
                gap = gap or missing[k, o]
        if gap:
            if settled:
                P[:] = stationary
            settled = False
            known_C, known_V, known_R = C.copy(), V.copy(), R.copy()
            for o in range(m):
                if missing[k, o]:
                    known_C[o], known_V[o], known_R[o, o] = 0.0, 0.0, 1.0
            _correct(known_C, known_C.T.copy(), known_V, known_V.T.copy(), known_R, P, PC,
                     state[k], held[k], innovation[k], inverse)  # fmt: skip
        elif not settled:
            _correct(C, CT, V, VT, R, P, PC, state[k], held[k], innovation[k], inverse)
            settled = first < 0 and np.abs(innovation[k] - last).max() <= SAME * size
            if settled and k >= last_change:
                break
        if settled:
            state[k], held[k], innovation[k] = last_state, last_held, last
        else:
            _propagate(A, AT, W, Q, P, state[k], held[k], innovation[k], AP, K, KT, KS)
        used = k + 1
    state[used], held[used], innovation[used] = last_state, last_held, last
    return state[: used + 1], held[: used + 1], innovation[: used + 1]
