"""The gains of the one-step predictor, from an unknown state to the stationary filter."""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from twin.estimation.system import Noise, Sampled

Array = NDArray[np.float64]

DOUBLINGS = 60
"""At most; each squares the number of samples that the covariance has settled over."""

SETTLED = 1e-13
"""Largest step, as a share of the largest covariance, with which the doubling has converged."""

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


def gains(sampled: Sampled, noise: Noise, first: int | None = None) -> Gains:
    """Return the gains (Kalman 1960; held disturbances correlate state and output noise).

    Args:
        sampled: the system.
        noise: levels, and the covariance of the state before the first sample.
        first: samples before the stationary gain takes over; as many as it needs without.

    Raises:
        ValueError: the Riccati equation has no stationary solution.
    """
    P, W, V, Q, R = _stationary_of(sampled, noise)
    state, held, innovation = _sequence(
        np.ascontiguousarray(sampled.whole), sampled.system.C, W, V, Q, R, noise.start, P,
        -1 if first is None else first,
    )  # fmt: skip
    return Gains(state, noise.held[:, None] * held, innovation, P)


def stationary_gains(sampled: Sampled, noise: Noise) -> Gains:
    """Return the stationary gains alone (``gains`` has those that lead there).

    Raises:
        ValueError: the Riccati equation has no stationary solution.
    """
    P, _, V, _, R = _stationary_of(sampled, noise)
    C = np.ascontiguousarray(sampled.system.C)
    state, held, innovation = _update(C, V, R, P)
    return Gains(state[None], noise.held[:, None] * held[None], innovation[None], P)


def _stationary_of(sampled: Sampled, noise: Noise) -> tuple[Array, Array, Array, Array, Array]:
    """Return the stationary covariance, W and V of unit disturbances, Q and R."""
    system = sampled.system
    W = np.ascontiguousarray(sampled.entry * noise.held)
    V = np.ascontiguousarray(system.V * noise.held)
    R = np.diag(noise.output**2)
    Q = W @ W.T + sampled.Q
    P = stationary(sampled.whole, system.C, Q, R + V @ V.T, W @ V.T)
    if not np.all(np.isfinite(P)):
        raise ValueError("the Riccati equation has no stationary solution")
    return P, W, V, Q, R


@numba.njit(nogil=True, cache=True)
def _update(C, V, R, P):  # type: ignore[no-untyped-def]
    S = C @ P @ C.T + V @ V.T + R
    inverse = np.linalg.inv(S)
    return P @ C.T @ inverse, V.T @ inverse, S


@numba.njit(nogil=True, cache=True)
def _sequence(A, C, W, V, Q, R, start, stationary, first):  # type: ignore[no-untyped-def]
    most = LONGEST_START if first < 0 else first
    n, m, w = A.shape[0], C.shape[0], W.shape[1]
    state = np.zeros((most + 1, n, m))
    held = np.zeros((most + 1, w, m))
    innovation = np.zeros((most + 1, m, m))
    C, V = np.ascontiguousarray(C), np.ascontiguousarray(V)
    last_state, last_held, last = _update(C, V, R, stationary)
    P = start.copy()
    used = 0
    for k in range(most):
        Kf, Ku, S = _update(C, V, R, P)
        if first < 0 and np.abs(S - last).max() <= SAME * np.abs(last).max():
            break
        state[k], held[k], innovation[k] = Kf, Ku, S
        K = A @ Kf + W @ Ku
        P = A @ P @ A.T + Q - K @ S @ K.T
        P = (P + P.T) / 2
        used = k + 1
    state[used], held[used], innovation[used] = last_state, last_held, last
    return state[: used + 1], held[: used + 1], innovation[: used + 1]


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
