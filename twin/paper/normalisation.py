"""What (41) makes of (47)-(48): with eigenvectors scaled as it needs, and as the paper did.

With Phi = [W; W Lambda] scaled so that Phi^T [[R, M], [M, 0]] Phi = I, inverting gives
Phi Phi^T = [[R, M], [M, 0]]^-1 = [[0, M^-1], [M^-1, -M^-1 R M^-1]]. Its four blocks are

    W W^T = 0,   W Lambda W^T = M^-1,   W Lambda^2 W^T = -M^-1 R M^-1,

and Phi^T [[K, 0], [0, -M]] Phi = -Lambda gives W Lambda^-1 W^T = -K^-1. The last three are (41);
the first, which the paper does not state, is what makes the three belong to one structure.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy import linalg

from twin.paper import printed
from twin.paper.printed import Array, symmetric, upper, values
from twin.paper.recompute import (
    eigenvectors_of_modal,
    matrices_of_modal,
    printed_poles,
    printed_shapes,
)
from twin.paper.rounding import misfit

MATRICES = printed.MASS_MATRIX + printed.STIFFNESS_MATRIX + printed.DAMPING_MATRIX
"""The nine entries of (50)-(52)."""

SIGNS: tuple[tuple[int, int], ...] = ((1, 1), (1, -1), (-1, 1), (-1, -1))
"""The four ways to take the two printed phases, each as it stands or with its sign turned."""


@dataclass(frozen=True)
class PrintedScale:
    """The scale of the eigenvectors with which (41) comes closest to (50)-(52).

    Attributes:
        sign: of the two phases.
        scale: (Re s1, Im s1, Re s2, Im s2), the squared scales of the two shapes.
        misfit: largest miss of the nine entries, half units of their last digit, with the inputs
            inside their rounding intervals.
        relative: largest miss with the digits as printed, over its matrix's largest entry.
        orthogonality: |W W^T| over |W|^2 (Frobenius): 0 where (41) may be used, at most 1.
    """

    sign: tuple[int, int]
    scale: tuple[float, ...]
    misfit: float
    relative: float
    orthogonality: float


def _blocks(modal: Array, sign: tuple[int, int], power: int) -> Array:
    """Return the (11, 12, 22) entries of W Lambda^power W^T as (3, 4), linear in the scale."""
    poles = printed_poles(modal[:2], modal[2:4])
    shapes = printed_shapes(modal[4:6], np.array(sign) * modal[6:8])
    columns = []
    for pole, shape in zip(poles, shapes.T, strict=True):
        block = 2 * pole**power * upper(np.outer(shape, shape))
        columns += [np.real(block), np.real(1j * block)]
    return np.column_stack(columns)


@cache
def nearest_scale(sign: tuple[int, int]) -> PrintedScale:
    """Return the scale that brings (41) nearest to (50)-(52): four numbers for nine entries."""
    modal = values(printed.MODAL)
    M, K, R = (
        symmetric(values(entries))
        for entries in (printed.MASS_MATRIX, printed.STIFFNESS_MATRIX, printed.DAMPING_MATRIX)
    )
    inverse = np.linalg.inv(M)
    rows, targets = [], []
    for power, target in ((1, inverse), (-1, -np.linalg.inv(K)), (2, -inverse @ R @ inverse)):
        size = float(np.linalg.norm(target))
        rows.append(_blocks(modal, sign, power) / size)
        targets.append(upper(target) / size)
    start = np.linalg.lstsq(np.vstack(rows), np.concatenate(targets), rcond=None)[0]
    miss = misfit(lambda x, s: matrices_of_modal(x, s, sign), printed.MODAL, MATRICES, tuple(start))
    W = eigenvectors_of_modal(modal, start, sign)
    orthogonality = float(np.linalg.norm(W @ W.T) / np.linalg.norm(W) ** 2)
    off = np.abs(matrices_of_modal(modal, start, sign) - values(MATRICES)).reshape(3, 3)
    relative = off / np.abs(values(MATRICES)).reshape(3, 3).max(axis=1, keepdims=True)
    return PrintedScale(sign, tuple(start), miss, float(relative.max()), orthogonality)


def exact_matrices(sign: tuple[int, int]) -> tuple[Array, Array, Array]:
    """Return the M, K, R that have exactly the modes of (47)-(48), scaled to M11 = 1 kg.

    W W^T = 0 is three linear equations for the four numbers of the scale, so that the modal
    parameters determine M, K and R up to one common factor.
    """
    modal = values(printed.MODAL)
    scale = linalg.null_space(_blocks(modal, sign, 0))[:, 0]
    entries = matrices_of_modal(modal, scale, sign)
    entries = entries / entries[0]
    return symmetric(entries[:3]), symmetric(entries[3:6]), symmetric(entries[6:])


def largest_passive_phase(M: Array, K: Array, damping_ratio: Array) -> Array:
    """Return the largest phase [rad] by which damping can turn each shape from 0 or pi, (2,).

    A damping matrix that only dissipates is positive semidefinite; in modal coordinates it is
    [[2 xi_1 w_1, r], [r, 2 xi_2 w_2]] with r^2 at most the product of the other two. At that
    limit the shapes are turned most.
    """
    stiffness, shapes = linalg.eigh(K, M)
    diagonal = 2 * np.asarray(damping_ratio) * np.sqrt(stiffness)
    # A hair inside the limit, where the modal damping matrix is still definite.
    r = np.sqrt(np.prod(diagonal)) * (1 - 1e-9)
    R = np.array([[diagonal[0], r], [r, diagonal[1]]])
    state = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.diag(stiffness), -R]])
    poles, vectors = np.linalg.eig(state)
    keep = np.flatnonzero(poles.imag > 0)
    keep = keep[np.argsort(poles[keep].imag)]
    damped = shapes @ vectors[:2, keep]
    angle = np.abs(np.angle(damped[1] / damped[0]))
    return np.asarray(np.minimum(angle, np.pi - angle))
