"""Least squares by the seminormal equations, for tall regressors solved again and again.

R comes from the Gram matrix, an order faster than a QR decomposition with its Q, and one step
more on the residual gives back the digits that this costs.

Source: Bjoerck 1987, Stability analysis of the method of seminormal equations.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

DEPENDENT = 1e-5
"""Sine of the angle between a column and the others below which normal equations lose too many
digits: its square is still far above the unit roundoff."""


def triangle(A: Array) -> Array:
    """Return R of A = Q R for columns of unit norm: by Cholesky unless they nearly depend."""
    try:
        R = linalg.cholesky(A.T @ A, check_finite=False)
        if np.diag(R).min() > DEPENDENT:
            return np.asarray(R)
    except np.linalg.LinAlgError:
        pass
    R = linalg.qr(A, mode="r", check_finite=False)[0][: A.shape[1]]
    R[np.diag_indices_from(R)] += 1e-14 * np.sign(np.diag(R) + 0.0)
    return np.asarray(R)


def least_squares(A: Array, R: Array, y: Array) -> tuple[Array, Array]:
    """Solve A c = y by the seminormal equations; return c and what is left of y.

    Once more on what is left makes up for their rounding (Bjoerck 1987).
    """
    c = np.asarray(linalg.cho_solve((R, False), A.T @ y, check_finite=False))
    return c, y - A @ c


def covariance_of(information: Array) -> Array:
    """Return the inverse of a Fisher information; what it tells nothing about is unknown.

    A pseudo-inverse would say of a direction without information that it is known exactly. Here
    it has the least information that rounding leaves.
    """
    diagonal = np.diag(information)
    size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(information / np.outer(size, size))
    least = len(size) * np.finfo(float).eps * max(float(values[-1]), 1.0)
    inverse = (vectors / np.maximum(values, least)) @ vectors.T
    return np.asarray(inverse / np.outer(size, size))


def real_rows(values: ComplexArray | Array) -> Array:
    """Stack real over imaginary parts, scaled so that a line's squared magnitude counts twice."""
    return np.sqrt(2) * np.vstack([values.real, values.imag])
