"""Damping that goes with the modes: their ratios are what a drawing says, whatever their shapes.

With nominal modes Phi0 (mass-normalised) and those of other masses and stiffnesses Phi, in the
order of the nominal ones that they resemble,

    R = (Phi^-T S Phi0^T) D (Phi0 S Phi^-1),    S = diag(sqrt(w / w0)):

the modal matrix of the nominal structure, 2 zeta w on its diagonal, with the new frequencies
(Clough and Penzien 1993, eq. 12-57).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.optimize import linear_sum_assignment

from twin.diagnosis.scales import ROUNDING
from twin.errors import NoLikelihoodError

Array = NDArray[np.float64]


def following(M0: Array, of_nominal: tuple[Array, Array], M: Array, K: Array, D: Array) -> Array:
    """Return a damping matrix (n, n) whose modal ratios are those of D on the nominal structure.

    Args:
        M0: mass matrix of that, (n, n).
        of_nominal: its ``modes_of``.
        M: mass matrix of the structure, (n, n).
        K: its stiffness matrix, (n, n).
        D: damping matrix of the nominal structure, (n, n).

    Raises:
        LinAlgError: as ``modes_of``.
    """
    w0, nominal = of_nominal
    w, shapes = modes_of(M, K)
    alike = nominal.T @ M0 @ shapes
    _, order = linear_sum_assignment(-np.abs(alike))
    w, shapes = w[order], shapes[:, order]
    # a mode that moves freely has no frequency to go with
    held = (w0 > 0) & (w > 0)
    S = np.where(held, np.sqrt(np.where(held, w, 1.0) / np.where(held, w0, 1.0)), 1.0)
    signs = np.where(np.diag(alike[:, order]) < 0, -1.0, 1.0)
    T = (nominal * (S * signs)) @ (shapes.T @ M)
    return np.asarray(T.T @ D @ T)


def modes_of(M: Array, K: Array) -> tuple[Array, Array]:
    """Return circular frequencies (n,), zero where there is none, and mass-normalised shapes.

    Raises:
        NoLikelihoodError: matrices without bounds.
        LinAlgError: masses that are not positive.
    """
    if not (np.all(np.isfinite(M)) and np.all(np.isfinite(K))):
        raise NoLikelihoodError("a structure without bounds")
    squares, shapes = eigh(0.5 * (K + K.T), 0.5 * (M + M.T))
    least = ROUNDING * np.max(np.abs(squares), initial=1e-300)
    return np.sqrt(np.where(squares > least, squares, 0.0)), shapes
