"""Eigensystem realization algorithm on the combined Markov parameters, eqs. (31)-(40)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft, linalg

from twin.errors import IdentificationError
from twin.state_space import StateSpace

Array = NDArray[np.float64]

DENSE_LIMIT = 600
"""Hankel matrices with a side up to this are decomposed densely, larger ones by sketching."""

OVERSAMPLING = 12
POWER_ITERATIONS = 2


@dataclass(frozen=True)
class HankelFactors:
    """Truncated SVD of the Hankel matrix N(0) of eq. (33).

    Attributes:
        R: left singular vectors, (block_rows * outputs, kept).
        singular_values: largest first, (kept,).
        S: right singular vectors, (block_columns * columns, kept).
        markov: the combined Markov parameters it is made of, entry 0 is [D, 0].
        block_rows: the paper's alpha.
        block_columns: the paper's beta.
    """

    R: Array
    singular_values: Array
    S: Array
    markov: Array
    block_rows: int
    block_columns: int

    @property
    def rank(self) -> int:
        """Number of singular values above rounding; the highest possible order."""
        sigma = self.singular_values
        floor = np.finfo(float).eps * max(len(self.R), len(self.S))
        return int(np.sum(sigma > floor * sigma[0]))

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
        shifted = _times(self.markov[2:], S, self.block_rows, self.block_columns)
        A = (R.T @ shifted) / np.outer(root, root)
        outputs, columns = self.markov.shape[1:]
        BG = root[:, None] * S[:columns].T
        C = R[:outputs] * root
        D = self.markov[0, :, :inputs]
        G = BG[:, inputs:] if columns > inputs else None
        return StateSpace(A, BG[:, :inputs], C, D, dt, G)


def era(
    markov: Array, block_rows: int | None = None, keep: int = 60, seed: int = 0
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
    if min(rows * m, columns * q) <= DENSE_LIMIT:
        index = np.arange(rows)[:, None] + np.arange(columns)[None, :]
        hankel = markov[1:][index].transpose(0, 2, 1, 3).reshape(rows * m, columns * q)
        R, sigma, St = linalg.svd(hankel, full_matrices=False, check_finite=False)
        return HankelFactors(R, sigma, St.T, markov, rows, columns)
    R, sigma, S = _sketched_svd(markov[1:], rows, columns, keep, seed)
    return HankelFactors(R, sigma, S, markov, rows, columns)


def _sketched_svd(
    gamma: Array, rows: int, columns: int, keep: int, seed: int
) -> tuple[Array, Array, Array]:
    transposed = gamma.transpose(0, 2, 1)
    width = min(keep + OVERSAMPLING, rows * gamma.shape[1], columns * gamma.shape[2])
    start = np.random.default_rng(seed).standard_normal((columns * gamma.shape[2], width))
    basis, _ = np.linalg.qr(_times(gamma, start, rows, columns))
    for _ in range(POWER_ITERATIONS):
        back, _ = np.linalg.qr(_times(transposed, basis, columns, rows))
        basis, _ = np.linalg.qr(_times(gamma, back, rows, columns))
    S, sigma, small = linalg.svd(_times(transposed, basis, columns, rows), full_matrices=False)
    kept = min(keep, width)
    return basis @ small[:kept].T, sigma[:kept], S[:, :kept]


def _times(gamma: Array, vectors: Array, rows: int, columns: int) -> Array:
    """Product of the block Hankel matrix, whose block (i, j) is gamma[i + j], with ``vectors``.

    Parameters beyond the end of ``gamma`` count as zero, which N(1) needs for its last block.
    """
    _, m, q = gamma.shape
    blocks = vectors.reshape(columns, q, -1)
    length = fft.next_fast_len(rows + 2 * columns - 1, real=True)
    spectrum = fft.rfft(gamma[: rows + columns - 1], length, axis=0)
    reversed_spectrum = fft.rfft(blocks[::-1], length, axis=0)
    product = fft.irfft(np.matmul(spectrum, reversed_spectrum), length, axis=0)
    return np.asarray(product[columns - 1 : columns - 1 + rows].reshape(rows * m, -1))
