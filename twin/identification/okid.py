"""Observer/Kalman filter identification of Markov parameters, eqs. (21)-(30)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from twin.errors import IdentificationError

Array = NDArray[np.float64]
Record = tuple[Array, Array]
"""One record: input (samples, inputs) and output (samples, outputs)."""

WELL_CONDITIONED = 1e-9
"""Normal equations square the condition number: below this reciprocal, QR is used instead."""

RANK_TOLERANCE = 1e-11
"""Singular values of the data matrix this far below the largest are rounding."""

LEAST_UNEXPLAINED = 1e-6
"""Share of an output's RMS that is taken as unexplained at least, where there is no noise."""

CHUNK = 8192
"""Rows a step of the streamed QR adds; memory does not grow with the record."""


@dataclass(frozen=True)
class ObserverMarkov:
    """Observer Markov parameters of eqs. (19) and (22).

    Attributes:
        D: direct transmission, (outputs, inputs).
        Y1: the parameters that multiply past inputs, (p, outputs, inputs).
        Y2: the parameters that multiply past outputs, signs as in eq. (21), (p, outputs, outputs).
        rank_deficient: the data matrix (27) has dependent rows, as noise-free data have when the
            observer is longer than it has to be; the solution is then the shortest of many.
        driving: RMS of what drives each column of the combined Markov parameters: the inputs, and
            the part of every output that the observer could not predict, (inputs + outputs,).
    """

    D: Array
    Y1: Array
    Y2: Array
    rank_deficient: bool
    driving: Array

    def markov(self, count: int) -> Array:
        """Return D and the combined Markov parameters of eqs. (29)-(31).

        Entry k >= 1 is Gamma_k = [Y_k, Y0_k]; entry 0 is [D, 0].

        Returns:
            Array of shape (count + 1, outputs, inputs + outputs); not finite where the recursion
            is unstable.
        """
        p, m, r = self.Y1.shape
        gamma = np.zeros((count + 1, m, r + m))
        gamma[0, :, :r] = self.D
        own = np.concatenate([self.Y1, self.Y2], axis=2)
        # Oldest first, so that the history of the recursion is one unbroken block of memory.
        past = np.concatenate(self.Y2[::-1], axis=1)
        with np.errstate(over="ignore", invalid="ignore"):
            for k in range(1, count + 1):
                reach = min(k, p)
                history = gamma[k - reach : k].reshape(reach * m, r + m)
                gamma[k] = -past[:, (p - reach) * m :] @ history
                if k <= p:
                    gamma[k] += own[k - 1]
        return gamma


def okid(
    records: Sequence[Record], p: int, at_rest: bool = True, ridge: float = 0.0
) -> ObserverMarkov:
    """Identify the observer Markov parameters by least squares over all records, eq. (28).

    The Gram matrix of the data matrix (27) is summed from lag products, without the data matrix;
    where it is ill-conditioned (little or no noise) a streamed QR factorisation, which does not
    square the condition number, takes its place.

    Args:
        records: inputs and outputs, each (samples, channels), of equal sampling rate.
        p: number of observer Markov parameters.
        at_rest: whether the zeros that (27) puts before the first sample are true.
        ridge: white noise to assume on every channel, as a share of its power. It keeps the
            observer of records that are nearly free of noise from growing without bound.

    Raises:
        IdentificationError: the records are too short for p.
    """
    r, m = records[0][0].shape[1], records[0][1].shape[1]
    unknowns = r + (r + m) * p
    usable = sum(len(u) if at_rest else max(len(u) - p, 0) for u, _ in records)
    if p < 1 or usable < unknowns:
        longest = max((sum(len(u) for u, _ in records) - r) // (r + m + (not at_rest)), 0)
        hint = f"use a p of at most {longest}" if longest else "record longer"
        raise IdentificationError(
            f"{usable} usable samples are too few for {unknowns} observer Markov parameters "
            f"(p = {p}); {hint}"
        )
    found = _by_normal_equations(records, p, at_rest, ridge) or _by_qr(records, p, at_rest)
    theta, unexplained, deficient = found
    D, past = theta[:r].T, theta[r:].reshape(p, r + m, m)
    total = [sum(np.sum(block[i] ** 2, axis=0) for block in records) for i in (0, 1)]
    unexplained = np.maximum(unexplained, LEAST_UNEXPLAINED**2 * total[1])
    driving = np.sqrt(np.concatenate([total[0], unexplained]) / usable)
    return ObserverMarkov(
        D, past[:, :r].transpose(0, 2, 1), -past[:, r:].transpose(0, 2, 1), deficient, driving
    )


def _by_normal_equations(
    records: Sequence[Record], p: int, at_rest: bool, ridge: float
) -> tuple[Array, Array, bool] | None:
    """Return the solution and the sum of squares it leaves of every output, or None."""
    r, m = records[0][0].shape[1], records[0][1].shape[1]
    q = r + m
    gram = _gram(np.hstack(records[0]), p, at_rest)
    for record in records[1:]:
        gram += _gram(np.hstack(record), p, at_rest)
    gram = gram.reshape((p + 1) * q, (p + 1) * q)
    scale = np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
    gram /= scale
    gram /= scale[:, None]
    target = np.arange(r, q)
    regressors = np.r_[0:r, q : (p + 1) * q]
    right = gram[np.ix_(regressors, target)]
    # Symmetric, so its transpose is the same matrix in the order of memory that LAPACK works in.
    normal = np.ascontiguousarray(gram[np.ix_(regressors, regressors)]).T
    del gram
    normal[np.diag_indices_from(normal)] += ridge
    norm = linalg.lapack.dlange("1", normal)
    factor, info = linalg.lapack.dpotrf(normal, overwrite_a=1, clean=0)
    if info != 0:
        return None
    reciprocal, _ = linalg.lapack.dpocon(factor, norm)
    if reciprocal < WELL_CONDITIONED and not ridge:
        return None
    solved, _ = linalg.lapack.dpotrs(factor, right)
    unexplained = (1 - np.sum(right * solved, axis=0)) * scale[target] ** 2
    return solved * scale[target] / scale[regressors, None], unexplained, False


def _gram(w: Array, p: int, at_rest: bool) -> Array:
    """Sum over time of the products of w(k-i) and w(k-j), (p+1, q, p+1, q).

    One lag product for each lag; the rest follows from the shift structure of (27): the sum for
    (i+1, j+1) is that for (i, j) without its newest product and, where the first p samples are
    only history, with one older product more.
    """
    samples, q = w.shape
    first = 0 if at_rest else p
    gram = np.zeros((p + 1, q, p + 1, q))
    for lag in range(min(p, samples - 1) + 1):
        start = max(first, lag)
        gram[0, :, lag] = w[start:].T @ w[start - lag : samples - lag]
    leaving = np.zeros((p, q))
    leaving[: min(p, samples)] = w[::-1][:p]
    entering = np.zeros((p, q)) if at_rest else w[:p][::-1]
    for i in range(p):
        gram[i + 1, :, i + 1 :] = gram[i, :, i:p]
        gram[i + 1, :, i + 1 :] -= leaving[i][:, None, None] * leaving[i:]
        if not at_rest:
            gram[i + 1, :, i + 1 :] += entering[i][:, None, None] * entering[i:]
        gram[i + 1 :, :, i] = gram[i, :, i + 1 :].transpose(1, 2, 0)
    return gram


def _shifted(w: Array, p: int, start: int, stop: int) -> Array:
    """Rows [w(k), w(k-1), .., w(k-p)] for start <= k < stop, zero before the first sample."""
    padded = np.vstack([np.zeros((p, w.shape[1])), w])
    return np.hstack([padded[p + start - lag : p + stop - lag] for lag in range(p + 1)])


def _chunks(records: Sequence[Record], p: int, at_rest: bool) -> Iterator[Array]:
    for u, y in records:
        w = np.hstack([u, y])
        for start in range(0 if at_rest else p, len(w), CHUNK):
            first = max(start - p, 0)
            stop = min(start + CHUNK, len(w))
            yield _shifted(w[first:stop], p, start - first, stop - first)


def _by_qr(records: Sequence[Record], p: int, at_rest: bool) -> tuple[Array, Array, bool]:
    r, m = records[0][0].shape[1], records[0][1].shape[1]
    q = r + m
    order = np.r_[0:r, q : (p + 1) * q, r:q]
    triangle = np.zeros((0, (p + 1) * q))
    for rows in _chunks(records, p, at_rest):
        triangle = np.asarray(np.linalg.qr(np.vstack([triangle, rows[:, order]]), mode="r"))
    unknowns = len(order) - m
    left, right = triangle[:unknowns, :unknowns], triangle[:unknowns, unknowns:]
    scale = np.maximum(np.linalg.norm(left, axis=0), np.finfo(float).tiny)
    solution, _, rank, _ = np.linalg.lstsq(left / scale, right, rcond=RANK_TOLERANCE)
    unexplained = np.sum(triangle[unknowns:, unknowns:] ** 2, axis=0)
    return solution / scale[:, None], unexplained, bool(rank < unknowns)
