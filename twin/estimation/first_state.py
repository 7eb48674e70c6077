"""The state before the first sample, integrated out in closed form beside stationary gains.

A filter that does not know the state it begins with has gains that change from sample to sample
until they settle, and so do their derivatives. With the stationary covariance P and the prior's P0
of that state, x0 = xi + d with xi of covariance P and d of P0 - P = D, independent: beside xi the
innovations of the stationary filter are white with covariance S, and d moves them by -H d (H: what
a first state does to innovations). So that, exactly, for linear systems,

    log p = sum_k log N(e_k; 0, S) + 1/2 b^T N b - 1/2 log det (1 + D G),
    b = H^T S^-1 e,   G = H^T S^-1 H,   N = D (1 + G D)^-1,

with the mean N b of d (the smoother's partitioned form; Lainiotis 1976; De Jong 1991). D need not
be positive, as where the state is known to begin with.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from twin.errors import NoLikelihoodError
from twin.estimation.density import Part
from twin.estimation.kalman import EquivalentLinear, Gains, matrices_of
from twin.estimation.riccati import summed
from twin.estimation.system import Noise, Sampled
from twin.estimation.trust import BESIDE_NOISE

Array = NDArray[np.float64]

FORGOTTEN = 1e-6
"""What is left of a first state in the innovations, as a share of its greatest, when it counts no
more: by its square, 1e-12, it tells less of itself."""


@dataclass(frozen=True)
class Settled:
    """A stationary filter, and what the first state, of which it knows too little, does to it.

    Attributes:
        gain: its gains, none before the first sample that was measured, then one for all.
        linear: A, C, W and V of unit disturbances, Q and R.
        closed: what a sample leaves of an error of the state, A - K C, (n, n).
        slopes: H whitened, of as many samples as it counts in, as rows, (rows, n).
        gramian: G, the observability Gramian of these samples, (n, n).
        posterior: N, the posterior covariance of d, (n, n).
        odds: -1/2 log det (1 + D G).
        samples: that were measured.
    """

    gain: Gains
    linear: tuple[Array, ...]
    closed: Array
    slopes: Array
    gramian: Array
    posterior: Array
    odds: float
    samples: int

    @property
    def first(self) -> int:
        """The first sample that was measured: its state is the one of which too little is known."""
        return len(self.gain.state) - 1

    @property
    def last(self) -> int:
        """The sample from which on nothing tells of that state."""
        return self.first + len(self.slopes) // self.gain.state.shape[2]

    @property
    def rows(self) -> slice:
        """Where ``slopes`` are among the whitened innovations as rows."""
        begin = self.first * self.gain.state.shape[2]
        return slice(begin, begin + len(self.slopes))

    def of(self, part: Part, state: Array) -> Beginning:
        """Return what innovations tell of the first state.

        Args:
            part: their density, after a first state.
            state: what of d was in that state, (n,).

        Raises:
            NoLikelihoodError: the model runs away.
        """
        still = self.slopes.T @ part.white.ravel()[self.rows]
        b = still + self.gramian @ state
        mean = self.posterior @ b
        value = part.value - float(state @ (still + b)) / 2 + 0.5 * float(b @ mean) + self.odds
        if not (np.isfinite(value) and np.all(np.isfinite(mean))):
            raise NoLikelihoodError("the model runs away from where the recording begins")
        return Beginning(mean, b - self.gramian @ mean, value)


@dataclass(frozen=True)
class Beginning:
    """What a recording tells of its first state beside a stationary filter.

    Attributes:
        state: the mean N b of d, (n,).
        pull: what the innovations after that state still tell of it, H^T S^-1 e, (n,): as much as
            its prior does, the other way.
        log_likelihood: with d integrated out.
    """

    state: Array
    pull: Array
    log_likelihood: float


def measured(y: Array) -> slice | None:
    """Return the samples that were measured, (samples, m); None with a gap between them."""
    missing = np.isnan(y)
    some = np.flatnonzero(~missing.all(axis=1))
    if not len(some):
        return None
    between = slice(int(some[0]), int(some[-1]) + 1)
    return None if missing[between].any() else between


def settled(
    plant: Sampled, noise: Noise, between: slice, blur: Array | None = None,
    equivalent: EquivalentLinear | None = None,
) -> Settled:  # fmt: skip
    """Return the stationary filter of a system.

    Args:
        plant: the sampled system.
        noise: levels, and the prior covariance of the first state.
        between: the samples that were measured.
        blur: variances of the outputs beside their noise's, (samples, m), if there are any.
        equivalent: what laws add to the linear system, if there are laws.

    Raises:
        NoLikelihoodError: no stationary filter, or outputs are without noise.
    """
    A, C, W, V, Q, R, P = matrices_of(plant, noise, equivalent)
    PC = P @ C.T
    S = C @ PC + V @ V.T + R
    try:
        root = np.linalg.inv(np.linalg.cholesky(S))
    except np.linalg.LinAlgError:
        raise NoLikelihoodError("the innovations' covariance is singular") from None
    inverse = root.T @ root
    state, held = PC @ inverse, V.T @ inverse
    K = A @ state + W @ held
    first, samples = between.start, between.stop - between.start
    blank = ((0, 0), (0, 0))
    gain = Gains(
        np.pad(state[None], ((first, 0), *blank)),
        np.pad((noise.held[:, None] * held)[None], ((first, 0), *blank)),
        np.repeat(S[None], first + 1, axis=0),
        P,
    )
    seen = Seen(C, S, root, K, A - K @ C)
    with np.errstate(all="ignore"):  # a filter that does not forget has no likelihood
        slopes = _slopes(seen, samples, None if blur is None else blur[between])
        gramian = slopes.T @ slopes
        start = after(A, Q, noise.start, first)
    posterior, log_det = _posterior(start, P, gramian)
    linear = A, C, W, V, plant.Q, R
    return Settled(gain, linear, seen.closed, slopes, gramian, posterior, -0.5 * log_det, samples)


@dataclass(frozen=True)
class Seen:
    """How a stationary filter sees a state: C, S, S's whitening, K and A - K C."""

    C: Array
    S: Array
    root: Array
    K: Array
    closed: Array


def _slopes(seen: Seen, samples: int, blur: Array | None) -> Array:
    """Return what a first state does to whitened innovations until nothing is left, (rows, n).

    Where outputs are more uncertain the filter believes them less (``trust``), and forgets less.
    """
    m = len(seen.C)
    first = seen.root @ seen.C
    least = FORGOTTEN * np.max(np.abs(first))
    rows, power = first, seen.closed  # twice as many at once
    while len(rows) < samples * m:
        more = rows @ power
        if not np.max(np.abs(more)) > least:
            break
        rows, power = np.vstack([rows, more]), power @ power
    rows = rows[: samples * m]
    less = np.zeros((0, m)) if blur is None else blur[: len(rows) // m]
    hit = np.flatnonzero(np.any(less > BESIDE_NOISE * np.diag(seen.S), axis=1)).tolist()
    if not hit:
        return np.ascontiguousarray(rows)
    out, moved, at = [], np.eye(len(seen.closed)), 0
    for k in (*hit, samples):
        out.append(rows[: (k - at) * m] @ moved)
        moved = np.linalg.matrix_power(seen.closed, k - at) @ moved
        if k == samples or not np.max(np.abs(first @ moved)) > least:
            break
        wide = seen.S + np.diag(less[k])
        out.append(np.linalg.solve(np.linalg.cholesky(wide), seen.C @ moved))
        trusted = np.linalg.solve(wide, seen.S).T
        moved = (seen.closed + seen.K @ (np.eye(m) - trusted) @ seen.C) @ moved
        at = k + 1
    return np.vstack(out)


def after(A: Array, Q: Array, start: Array, samples: int) -> Array:
    """Return the covariance of a state after samples that were not measured, (..., n, n)."""
    if not samples:
        return start
    moved = np.linalg.matrix_power(A, samples)
    return np.asarray(moved @ start @ moved.swapaxes(-1, -2) + summed(A, Q, samples))


def _posterior(start: Array, P: Array, gramian: Array) -> tuple[Array, float]:
    """Return D (1 + G D)^-1 and log det (1 + D G), of D = P0 - P, all symmetric, (n, n).

    With D = L J L^T, J of ones and minus ones, in units of both covariances: there a prior may be
    1e10 times as wide as what is told.

    Raises:
        NoLikelihoodError: no covariance of the state is left that is positive.
    """
    if not (np.all(np.isfinite(start)) and np.all(np.isfinite(gramian))):
        raise NoLikelihoodError("the first state may be anywhere")
    size = np.sqrt(np.maximum(np.diag(start) + np.diag(P), 0.0))
    scale = np.where(size > 0, size, 1.0)
    values, vectors = eigh((start - P) / np.outer(scale, scale))
    kept = np.abs(values) > len(values) * np.finfo(float).eps * np.max(np.abs(values), initial=0.0)
    signs = np.sign(values[kept])
    L = scale[:, None] * vectors[:, kept] * np.sqrt(np.abs(values[kept]))
    inner = np.diag(signs) + L.T @ gramian @ L
    sign, log_det = np.linalg.slogdet(signs[:, None] * inner)
    if not sign > 0:
        raise NoLikelihoodError("the first state has no covariance")
    posterior = L @ np.linalg.solve(inner, L.T)
    return np.asarray((posterior + posterior.T) / 2), float(log_det)
