"""Least-squares complex frequency: poles of all orders from one set of normal equations.

With x = exp(-j theta), theta running around most of the unit circle inside the band, every output
o obeys A(x) Y_o = sum_j B_oj(x) U_j + sum_s T_os(x) at the lines of record s; A is common to all
outputs. T is what a record's end and start states add (leakage). The sums over lines depend on
the difference of two powers only, so that all blocks are Toeplitz; B and T are eliminated, and
each order takes a corner of what is left.

Source: Guillaume, Verboven, Vanlanduit, Van der Auweraer and Peeters, 2003 (poly-reference LSCF);
Cauberghe 2004 (which coefficient is fixed at 1 parts physical from mathematical poles); Pintelon
and Schoukens 2012, ch. 6 (transient polynomial).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from twin.identification.spectra import Spectrum

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

CIRCLE = 0.9
"""Share of the unit circle that the band covers; the rest keeps its ends apart."""


@dataclass(frozen=True)
class Denominator:
    """Normal equations of the common denominator, numerators eliminated.

    Attributes:
        gram: of the coefficients of x^0 .. x^highest, (highest + 1, highest + 1).
        low: lower end of the band [rad/s].
        scale: radians of theta for one rad/s.
    """

    gram: ComplexArray
    low: float
    scale: float

    def poles(self, order: int) -> ComplexArray:
        """Return the decaying poles of one order inside the band [rad/s], by frequency."""
        block = self.gram[: order + 1, : order + 1]
        ridge = 1e-14 * np.trace(block).real * np.eye(order)
        # The coefficient of the constant fixed at 1: poles that only fit noise then grow.
        a = linalg.solve(block[1:, 1:] + ridge, -block[1:, 0], assume_a="her")
        roots = np.roots(np.concatenate([a[::-1], [1.0]]))
        roots = roots[np.abs(roots) > 0]
        s = -np.log(roots.astype(complex))
        theta = np.mod(s.imag + np.pi * (1 - CIRCLE), 2 * np.pi) - np.pi * (1 - CIRCLE)
        poles = s.real / self.scale + 1j * (self.low + theta / self.scale)
        inside = (theta >= 0) & (theta <= 2 * np.pi * CIRCLE) & (poles.real < 0)
        return np.asarray(poles[inside][np.argsort(poles[inside].imag)])


def denominator(
    spectra: Sequence[Spectrum], highest: int, weights: Sequence[Array] | None = None
) -> Denominator:
    """Set up the normal equations of the common denominator for all orders up to ``highest``.

    Args:
        spectra: the records.
        highest: highest order, in poles of positive frequency.
        weights: of every line of every record, (bins,); 1 by default.
    """
    low = min(float(s.omega[0]) for s in spectra)
    high = max(float(s.omega[-1]) for s in spectra)
    scale = 2 * np.pi * CIRCLE / (high - low)
    count = highest + 1
    column = np.cumsum([s.transient for s in spectra])
    r, m = spectra[0].U.shape[1], spectra[0].Y.shape[1]
    q = r + int(column[-1])
    blocks = np.zeros((q, q, 2 * count - 1), complex)
    cross = np.zeros((q, m, 2 * count - 1), complex)
    own = np.zeros((m, 2 * count - 1), complex)
    for i, s in enumerate(spectra):
        lags = np.arange(-highest, highest + 1)
        power = np.exp(-1j * np.outer(lags, scale * (s.omega - low)))
        w = np.ones(len(s.omega)) if weights is None else weights[i]
        X = np.zeros((len(s.omega), q), complex)
        X[:, :r] = s.U
        if s.transient:
            X[:, r + column[i] - 1] = 1
        wX = X.conj() * w[:, None]
        blocks += np.einsum("lk,ki,kj->ijl", power, wX, X, optimize=True)
        cross += np.einsum("lk,ki,kj->ijl", power, wX, s.Y, optimize=True)
        own += (power @ (np.abs(s.Y) ** 2 * w[:, None])).T
    # Entry (a, b) of a Toeplitz block holds the lag b - a.
    at = np.arange(count)[None, :] - np.arange(count)[:, None] + highest
    big = blocks[:, :, at].transpose(0, 2, 1, 3).reshape(q * count, q * count)
    side = cross[:, :, at].transpose(0, 2, 1, 3).reshape(q * count, m * count)
    size = np.sqrt(np.maximum(np.diag(big).real, np.finfo(float).tiny))
    big = big / np.outer(size, size) + 1e-13 * np.eye(len(big))
    factor = linalg.cholesky(big, lower=True, check_finite=False)
    half = linalg.solve_triangular(factor, side / size[:, None], lower=True, check_finite=False)
    half = half.reshape(-1, m, count)
    gram = np.zeros((count, count), complex)
    for o in range(m):
        part = own[o][at] - half[:, o].conj().T @ half[:, o]
        gram += part / max(float(own[o][highest].real), np.finfo(float).tiny)
    return Denominator(np.asarray((gram + gram.conj().T) / 2, complex), low, scale)
