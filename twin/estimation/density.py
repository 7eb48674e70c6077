"""The Gaussian density of innovations, compiled."""

# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from twin.errors import NoLikelihoodError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Part:
    """One recording's share of a log likelihood.

    Attributes:
        value: log density [nat].
        white: whitened innovations L^-1 e with S = L L^T, (samples, m).
        balance: S^-1 - S^-1 e e^T S^-1 of the first samples, and summed over all later ones,
            (t, m, m).
        roots: L^-1 of every sample, (samples, m, m).
    """

    value: float
    white: Array
    balance: Array
    roots: Array

    def whitened(self, de: Array) -> Array:
        """Return L^-1 de for every sample as rows, (samples m, p)."""
        samples, m, p = de.shape
        out = np.empty_like(de)
        _through(self.roots, np.ascontiguousarray(de), out)
        return out.reshape(samples * m, p)


def density(e: Array, y: Array, innovation: Array, blur: Array | None) -> Part:
    """Return the log density of innovations and what its derivatives need.

    Args:
        e: innovations, (samples, m).
        y: what was measured, (samples, m); what is NaN does not count.
        innovation: covariances of the first samples, the last one for all later ones, (t, m, m).
        blur: further variances of the outputs, (samples, m), or None.

    Raises:
        NoLikelihoodError: a covariance that is not positive.
    """
    samples, m = e.shape
    roots, white = np.zeros((samples, m, m)), np.empty((samples, m))
    balance = np.zeros((len(innovation), m, m))
    more = np.zeros((0, m)) if blur is None else np.ascontiguousarray(blur)
    c = np.ascontiguousarray
    value = _density(c(e), c(y), c(innovation), more, roots, white, balance)
    if not np.isfinite(value):
        raise NoLikelihoodError(
            "the innovations have no density: the model runs away, or a covariance is not positive"
        )
    return Part(float(value), white, balance, roots)


@numba.njit(nogil=True, cache=True)
def _density(e, y, innovation, blur, roots, white, balance):
    samples, m = e.shape
    S, missing, pull = np.zeros((m, m)), np.zeros(m, np.bool_), np.zeros(m)
    inverse = np.zeros((m, m))
    value, log_det, known = 0.0, 0.0, -1
    for k in range(samples):
        which = min(k, len(innovation) - 1)
        whole = True
        for o in range(m):
            missing[o] = np.isnan(y[k, o])
            whole = whole and not missing[o] and (len(blur) == 0 or blur[k, o] == 0.0)
        if whole and known == which:
            roots[k] = roots[k - 1]
        else:
            for o in range(m):
                for i in range(m):
                    S[o, i] = 0.0 if missing[o] or missing[i] else innovation[which, o, i]
                if missing[o]:
                    S[o, o] = 1.0
                elif len(blur):
                    S[o, o] += blur[k, o]
            log_det = _inverse_root(S, roots[k])
            if np.isnan(log_det):
                return np.nan
            known = which if whole else -1
            for i in range(m):
                for l in range(m):  # noqa: E741
                    inverse[i, l] = 0.0
                    for o in range(max(i, l), m):
                        inverse[i, l] += roots[k, o, i] * roots[k, o, l]
        value -= 0.5 * log_det
        for o in range(m):
            total = 0.0
            for i in range(o + 1):
                total += roots[k, o, i] * e[k, i]
            white[k, o] = total
            value -= 0.5 * total**2
            if not missing[o]:
                value -= 0.5 * np.log(2 * np.pi)
        for i in range(m):
            pull[i] = 0.0
            for o in range(i, m):
                pull[i] += roots[k, o, i] * white[k, o]
        for i in range(m):
            for l in range(m):  # noqa: E741
                if missing[i] or missing[l]:
                    continue
                balance[which, i, l] += inverse[i, l] - pull[i] * pull[l]
    return value


@numba.njit(nogil=True, cache=True)
def _inverse_root(S, out):
    """Fill L^-1 with S = L L^T (S is overwritten); return log det S, NaN where not positive."""
    m = len(S)
    log_det = 0.0
    for j in range(m):
        for i in range(j):
            S[j, j] -= S[j, i] ** 2
        if not S[j, j] > 0.0:
            return np.nan
        S[j, j] = np.sqrt(S[j, j])
        log_det += 2 * np.log(S[j, j])
        for o in range(j + 1, m):
            for i in range(j):
                S[o, j] -= S[o, i] * S[j, i]
            S[o, j] /= S[j, j]
    for j in range(m):
        for o in range(m):
            out[o, j] = 0.0
        out[j, j] = 1.0 / S[j, j]
        for o in range(j + 1, m):
            total = 0.0
            for i in range(j, o):
                total -= S[o, i] * out[i, j]
            out[o, j] = total / S[o, o]
    return log_det


@numba.njit(nogil=True, cache=True)
def _through(roots, de, out):
    samples, m, p = de.shape
    for k in range(samples):
        for o in range(m):
            c = roots[k, o, 0]
            for a in range(p):
                out[k, o, a] = c * de[k, 0, a]
            for i in range(1, o + 1):
                c = roots[k, o, i]
                if c != 0.0:
                    for a in range(p):
                        out[k, o, a] += c * de[k, i, a]
