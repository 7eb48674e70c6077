"""Modes far above the band are left out, all but what they do statically.

Kept are the modes within the band and, of the rest, the static displacements that the inputs, the
shaken ground and the named joints and tendons cause: modal truncation augmentation. What then is
still lacking is stated as a share of a static displacement.

Source: Dickens, Nakagawa and Wittbrodt 1997, A critique of mode acceleration and modal truncation
augmentation methods, Computers and Structures 62.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from twin.model.linear import LinearModel
from twin.model.port import Port

Array = NDArray[np.float64]

FREEDOMS = 40
"""A model of at most so many freedoms is never truncated: its cost is small."""

MARGIN = 2.0
"""Modes up to so many times the band are kept as they are: at the end of the band the static share
of a mode above is then right to a quarter or better, and the vectors correct most of that."""


def kept_shapes(model: LinearModel, stiffness: Array, band_hz: float | None) -> Array | None:
    """Return the coordinates to keep as columns (n, k), or None for all.

    Args:
        model: all modes, in modal coordinates.
        stiffness: squared natural frequencies, rising [rad^2/s^2], (n,).
        band_hz: highest frequency that matters [Hz], or None.
    """
    n = len(stiffness)
    if n <= FREEDOMS:
        return None
    limit = stiffness[FREEDOMS - 1] if band_hz is None else (2 * np.pi * MARGIN * band_hz) ** 2
    low = int(np.sum(stiffness <= limit))
    if low == n:
        return None
    forces = np.column_stack(
        [model.B, *(b.row for b in model.base.values()), *(p.row for p in _drifts(model))]
    )[low:]
    static = forces / stiffness[low:, None]
    # scaled to one, so that a weak entry counts like a strong one
    static /= np.maximum(np.linalg.norm(static, axis=0), 1e-300)
    vectors, size, _ = np.linalg.svd(static, full_matrices=False)
    vectors = vectors[:, size > 1e-6 * size[0]]
    _, turned = linalg.eigh(vectors.T @ (stiffness[low:, None] * vectors))
    T = np.zeros((n, low + vectors.shape[1]))
    T[:low, :low] = np.eye(low)
    T[low:, low:] = vectors @ turned
    return None if T.shape[1] >= n else T


def left_out(model: LinearModel, stiffness: Array, T: Array) -> float:
    """Return the largest share of a static displacement that the kept coordinates lack.

    Compared are the displacements that a unit force at an input or port causes at itself, rigid
    motion left aside.
    """
    elastic = np.flatnonzero(stiffness > 0)
    rows = np.vstack([model.B.T, *(p.row for p in model.ports.values())])[:, elastic]
    whole = np.sum(rows**2 / stiffness[elastic], axis=1)
    kept = T[elastic]
    kept = kept[:, np.linalg.norm(kept, axis=0) > 0]
    part = np.sum((rows @ kept) ** 2 / np.sum(stiffness[elastic, None] * kept**2, axis=0), axis=1)
    return float(
        np.max(1 - part / np.where(whole > 0, whole, np.inf), initial=0.0, where=whole > 0)
    )


def _drifts(model: LinearModel) -> list[Port]:
    return [port for port in model.ports.values() if port.kind == "drift"]
