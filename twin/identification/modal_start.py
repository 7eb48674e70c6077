"""A first guess of all modal parameters from poles alone: linear least squares, then rank one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.identification.modal_response import Hold, ModalParameters, basis
from twin.identification.spectra import Spectrum

ComplexArray = NDArray[np.complex128]
Array = NDArray[np.float64]

LEAST_DAMPING = 1e-5
MOST_DAMPING = 0.9


def from_poles(
    poles: ComplexArray, spectra: Sequence[Spectrum], hold: Hold, w_max: float, residual: bool
) -> ModalParameters:
    """Solve for residues, direct terms and transients at fixed poles, then split the residues.

    Args:
        poles: continuous-time poles with positive imaginary part [rad/s], (modes,).
        spectra: the records.
        hold: what the input does between its samples.
        w_max: highest analysed angular frequency [rad/s].
        residual: whether the out-of-band term is part of the model.
    """
    n, m, r = len(poles), spectra[0].Y.shape[1], spectra[0].U.shape[1]
    blocks, targets = [], []
    own = [2 * n + s.edge_columns.shape[1] for s in spectra]
    common = 2 * n * r + r * (1 + residual)
    for index, s in enumerate(spectra):
        b, _, t, _ = basis(poles, s, hold)
        c, _, u, _ = basis(poles.conj(), s, hold)
        plus = (b[:, :, None] * s.U[:, None, :]).reshape(len(b), n * r)
        minus = (c[:, :, None] * s.U[:, None, :]).reshape(len(b), n * r)
        shared = [plus + minus, 1j * (plus - minus), s.U]
        if residual:
            shared.append(s.U * (s.omega[:, None] / w_max) ** 2)
        private = np.hstack([t + u, 1j * (t - u), s.edge_columns])
        left, right = sum(own[:index]), sum(own[index + 1 :])
        rows = len(b)
        blocks.append(
            np.hstack([*shared, np.zeros((rows, left)), private, np.zeros((rows, right))])
        )
        targets.append(s.Y)
    X, Y = np.vstack(blocks), np.vstack(targets)
    X, Y = np.vstack([X.real, X.imag]), np.vstack([Y.real, Y.imag])
    scale = np.maximum(np.linalg.norm(X, axis=0), np.finfo(float).tiny)
    solution = np.linalg.lstsq(X / scale, Y, rcond=None)[0] / scale[:, None]

    residues = (solution[: n * r] + 1j * solution[n * r : 2 * n * r]).reshape(n, r, m)
    direct = solution[2 * n * r : common].reshape(1 + residual, r, m).transpose(0, 2, 1)
    free, edges, at = [], [], common
    for count in own:
        part = solution[at : at + count]
        free.append(part[:n] + 1j * part[n : 2 * n])
        edges.append(part[2 * n :])
        at += count
    return _rank_one(
        poles, residues, np.array(free), direct[0], direct[1] if residual else 0 * direct[0], edges
    )


def _rank_one(
    poles: ComplexArray,
    residues: ComplexArray,
    free: ComplexArray,
    D: Array,
    D2: Array,
    edges: list[Array],
) -> ModalParameters:
    n, r, m = residues.shape
    psi = np.empty((m, n), complex)
    participation = np.empty((n, r), complex)
    transient = np.empty((len(free), n), complex)
    for i in range(n):
        # Residues decide the shape; free responses only where the input left none.
        u, _, _ = np.linalg.svd(residues[i].T, full_matrices=False)
        shape = u[:, 0]
        psi[:, i] = shape / shape[np.argmax(np.abs(shape))]
        dual = psi[:, i].conj() / np.sum(np.abs(psi[:, i]) ** 2)
        participation[i] = residues[i] @ dual
        transient[:, i] = free[:, i] @ dual
    omega = np.abs(poles)
    zeta = np.clip(-poles.real / omega, LEAST_DAMPING, MOST_DAMPING)
    anchor = np.argmax(np.abs(psi), axis=0)
    return ModalParameters(omega, zeta, psi, anchor, participation, D, D2, transient, tuple(edges))
