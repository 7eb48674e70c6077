"""The model at one drive with everything linear solved for, and how the drive moves it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.identification.separable_terms import Drive

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True)
class Projected:
    """The model at one drive, everything linear solved for.

    Attributes:
        cost: weighted sum of squares (twice the negative log likelihood without determinants).
        psi: shapes, (outputs, n).
        direct: coefficients of the direct terms and free ends, (columns, outputs).
        error: residual spectra, not weighted, (lines, outputs).
        gram: Gauss-Newton matrix of the drive's real parameters, or None.
        right: its right-hand side, or None.
        loss: by how much the cost rises when a mode is left out, the rest of the linear
            parameters solved for anew, (n,); None where it was not asked for.
    """

    cost: float
    psi: ComplexArray
    direct: Array
    error: ComplexArray
    gram: Array | None = None
    right: Array | None = None
    loss: Array | None = None


def turn(drive: Drive, psi: ComplexArray, moving: NDArray[np.intp]) -> Array:
    """How a unit of each real parameter enters the two real regressors of its component.

    Returns:
        (outputs, n, components, 2 regressors, 2 parameters).
    """
    drive, psi = drive.only(moving), psi[:, moving]
    root = np.sqrt(1 - drive.zeta**2)
    by_zeta = drive.zeta * drive.omega * (-1 - 1j * drive.zeta / root)
    unit = np.empty((*drive.v.shape, 2), complex)
    unit[:, 0, 0], unit[:, 0, 1] = drive.poles, by_zeta
    unit[:, 1:, 0], unit[:, 1:, 1] = 1, 1j
    delta = psi[:, :, None, None] * unit
    return np.stack([delta.real, delta.imag], axis=3)
