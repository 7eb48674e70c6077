"""Eigensystem realization algorithm on the combined Markov parameters, eqs. (31)-(40)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import fft, linalg

from twin.errors import IdentificationError
from twin.state_space import StateSpace

Array = NDArray[np.float64]

DENSE_LIMIT = 200
"""Hankel matrices with a side up to this are decomposed densely, larger ones by sketching."""

OVERSAMPLING = 12
POWER_ITERATIONS = 2
NEARLY_ORTHONORMAL = 0.01
"""Beyond this deviation of Q^T Q from 1, a first Cholesky factor was too inaccurate to trust."""


@dataclass(frozen=True)
class HankelFactors:
    """Truncated SVD of the Hankel matrix N(0) of eq. (33).

    Attributes:
        R: left singular vectors, (block_rows * outputs, kept).
        singular_values: largest first, (kept,).
        S: right singular vectors, (block_columns * columns, kept).
        markov: the combined Markov parameters it is made of, entry 0 is [D, 0], weighted.
        block_rows: the paper's alpha.
        block_columns: the paper's beta.
        weights: what the columns of the Markov parameters were multiplied with, (columns,).
    """

    R: Array
    singular_values: Array
    S: Array
    markov: Array
    block_rows: int
    block_columns: int
    weights: Array

    @property
    def rank(self) -> int:
        """Number of singular values above rounding; the highest possible order."""
        sigma = self.singular_values
        floor = np.finfo(float).eps * max(len(self.R), len(self.S))
        return int(np.sum(sigma > floor * sigma[0]))

    @cached_property
    def _shifted(self) -> Array:
        """R^T N(1) S for all kept singular vectors, of which every order takes a corner.

        N(1) is N(0) moved up by one block, with one new block row; N(0) S is R diag(sigma).
        """
        m = self.markov.shape[1]
        new = self.markov[self.block_rows + 1 :].transpose(1, 0, 2).reshape(m, -1)
        moved = self.R[:-m].T @ self.R[m:] * self.singular_values
        return np.asarray(moved + self.R[-m:].T @ (new @ self.S))

    def realize(self, order: int, dt: float, inputs: int) -> StateSpace:
        """Return the realization (38) of the given order, observer gain included.

        Raises:
            IdentificationError: the order exceeds the number of non-zero singular values.
        """
        sigma = self.singular_values
        if not 1 <= order <= self.rank:
            raise IdentificationError(
                f"an order of {order} is not possible: the Hankel matrix has rank {self.rank}"
            )
        R, S, root = self.R[:, :order], self.S[:, :order], np.sqrt(sigma[:order])
        A = self._shifted[:order, :order] / np.outer(root, root)
        outputs, columns = self.markov.shape[1:]
        BG = root[:, None] * S[:columns].T / self.weights
        C = R[:outputs] * root
        D = self.markov[0, :, :inputs] / self.weights[:inputs]
        G = BG[:, inputs:] if columns > inputs else None
        return StateSpace(A, BG[:, :inputs], C, D, dt, G)


def era(
    markov: Array,
    block_rows: int | None = None,
    keep: int = 60,
    seed: int = 0,
    driving: Array | None = None,
) -> HankelFactors:
    """Factorise the block Hankel matrix of the Markov parameters, eqs. (32)-(37).

    Small matrices get a full SVD. Large ones are never formed: their product with a block of
    vectors is a convolution, so a randomised SVD (Halko, Martinsson and Tropp 2011) needs only
    FFTs, and keeps the ``keep`` largest singular values.

    Args:
        markov: [Y_k, Y0_k] with [D, 0] as entry 0, (count + 1, outputs, columns).
        block_rows: the paper's alpha; half of the Markov parameters by default.
        keep: singular values to compute when the matrix is large.
        seed: of the random sketch.
        driving: RMS of what drives each column, inputs and unpredicted outputs: the columns are
            then weighted with it, relative to the first. Without weights the columns of the
            observer gain, in other units, may outweigh those of the input, and the truncated
            SVD serves them first.

    Raises:
        IdentificationError: fewer than three Markov parameters beyond entry 0.
    """
    count = len(markov) - 1
    if count < 3:
        raise IdentificationError(f"{count} Markov parameters are too few for a Hankel matrix")
    rows = block_rows or count // 2
    columns = count - rows
    if rows < 1 or columns < 1:
        raise IdentificationError(f"{rows} block rows need more than {count} Markov parameters")
    _, m, q = markov.shape
    weights = np.ones(q) if driving is None else np.asarray(driving) / driving[0]
    if driving is not None:
        markov = markov * weights
    if min(rows * m, columns * q) <= DENSE_LIMIT:
        index = np.arange(rows)[:, None] + np.arange(columns)[None, :]
        hankel = markov[1:][index].transpose(0, 2, 1, 3).reshape(rows * m, columns * q)
        R, sigma, St = linalg.svd(hankel, full_matrices=False, check_finite=False)
        return HankelFactors(R, sigma, St.T, markov, rows, columns, weights)
    R, sigma, S = _sketched_svd(implicit_hankel(markov[1:], rows, columns), keep, seed)
    return HankelFactors(R, sigma, S, markov, rows, columns, weights)


@dataclass(frozen=True)
class ImplicitHankel:
    """Block Hankel matrix, whose block (i, j) is gamma[i + j], known by its products only.

    Attributes:
        spectrum: transform of gamma, (frequencies, outputs, columns).
        length: samples of the circular convolution that stands for the product.
        block_rows: blocks from top to bottom.
        block_columns: blocks from left to right.
    """

    spectrum: NDArray[np.complex128]
    length: int
    block_rows: int
    block_columns: int

    @property
    def T(self) -> ImplicitHankel:
        """The transposed matrix."""
        transposed = self.spectrum.transpose(0, 2, 1)
        return ImplicitHankel(transposed, self.length, self.block_columns, self.block_rows)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        _, m, q = self.spectrum.shape
        return self.block_rows * m, self.block_columns * q

    def __matmul__(self, vectors: Array) -> Array:
        """Multiply with ``vectors``, (rows or columns of the matrix, count)."""
        blocks = vectors.reshape(self.block_columns, self.spectrum.shape[2], -1)
        # The conjugate spectrum of the blocks runs them backwards in time, as the product needs.
        # What wraps around falls on the entries beyond block_rows.
        blocks = fft.rfft(blocks, self.length, axis=0)
        np.conjugate(blocks, out=blocks)
        product = fft.irfft(self.spectrum @ blocks, self.length, axis=0, overwrite_x=True)
        return np.asarray(product[: self.block_rows].reshape(self.shape[0], -1))


def implicit_hankel(gamma: Array, block_rows: int, block_columns: int) -> ImplicitHankel:
    """Return the block Hankel matrix of ``gamma``, (at least rows + columns - 1, m, q)."""
    needed = block_rows + block_columns - 1
    length = fft.next_fast_len(needed, real=True)
    return ImplicitHankel(
        fft.rfft(gamma[:needed], length, axis=0), length, block_rows, block_columns
    )


def _sketched_svd(hankel: ImplicitHankel, keep: int, seed: int) -> tuple[Array, Array, Array]:
    width = min(keep + OVERSAMPLING, *hankel.shape)
    start = np.random.default_rng(seed).standard_normal((hankel.shape[1], width))
    basis = _orthonormal(hankel @ start)
    for _ in range(POWER_ITERATIONS):
        basis = _orthonormal(hankel @ _orthonormal(hankel.T @ basis))
    across = hankel.T @ basis
    Q = _orthonormal(across)
    left, sigma, right = linalg.svd(across.T @ Q, check_finite=False)
    kept = min(keep, width)
    return basis @ left[:, :kept], sigma[:kept], Q @ right[:kept].T


def _orthonormal(tall: Array) -> Array:
    """Return an orthonormal basis of the columns.

    By Cholesky factors of the Gram matrix, twice (CholeskyQR2), ten times faster for tall
    matrices than Householder's reflections, which remain for nearly dependent columns.

    Source: Yamamoto, Nakatsukasa, Yanagisawa and Fukaya, 2015.
    """
    Q = tall
    for again in (False, True):
        gram = Q.T @ Q
        if again and np.abs(gram - np.eye(len(gram))).max() > NEARLY_ORTHONORMAL:
            break
        factor, failed = linalg.lapack.dpotrf(gram)
        if failed:
            break
        Q = linalg.blas.dtrsm(1.0, factor, Q.T, trans_a=1).T
    else:
        return np.asarray(Q)
    return np.asarray(np.linalg.qr(tall)[0])
