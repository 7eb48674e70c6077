"""Modes that a subspace method found from responses alone, refined group by group."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.identification.output_likelihood import (
    MOST_TOGETHER,
    NUMERATORS,
    Likeliest,
    groups,
    lines,
    refine,
)
from twin.modal import ModalModel
from twin.recording import Recording

Array = NDArray[np.float64]

DISTINCT = 0.1
"""Least singular value of the unit shapes that are taken apart: noise grows at most tenfold."""


def refined(
    modal: ModalModel, y: Sequence[Array], rate: float, power: int
) -> tuple[ModalModel, NDArray[np.bool_]]:
    """Return modes with the likeliest frequencies and dampings, and which of them have these.

    Args:
        modal: modes by frequency, with deviations; the shapes are kept.
        y: outputs of every record, (samples, outputs).
        rate: their sampling rate [Hz].
        power: of s by which the sensors see displacement.
    """
    assert modal.natural_freq_std is not None
    assert modal.damping_ratio_std is not None
    f, zeta = modal.natural_freq.copy(), modal.damping_ratio.copy()
    std = np.array([modal.natural_freq_std, modal.damping_ratio_std])
    shapes = _real(modal.mode_shape)
    likeliest = np.zeros(len(f), bool)
    for members, band in groups(f, zeta):
        if len(members) > min(MOST_TOGETHER, len(shapes)):
            continue
        apart = _apart(shapes, members)
        if apart is None:
            continue
        data = lines([x @ apart.T for x in y], rate, band)
        found = refine(data, modal.natural_freq[members], modal.damping_ratio[members], power)
        if found is None or not _same(found, modal, members):
            continue
        f[members], zeta[members], std[:, members] = found.frequency_hz, found.damping, found.std
        likeliest[members] = True
    kept = replace(
        modal, natural_freq=f, damping_ratio=zeta, natural_freq_std=std[0],
        damping_ratio_std=std[1],
    )  # fmt: skip
    return kept, likeliest


def numerator_power(recordings: Sequence[Recording], names: Sequence[str]) -> int:
    """Return the power of s by which most of some channels see displacement."""
    kinds = {c.name: c.kind for c in recordings[0].channels}
    seen = Counter(NUMERATORS.get(kinds[name], 2) for name in names)
    return seen.most_common(1)[0][0]


def _real(shapes: NDArray[np.complex128]) -> Array:
    """Return the shapes turned to where they are nearest to real, of unit length."""
    turned = shapes * np.exp(-0.5j * np.angle(np.sum(shapes**2, axis=0)))
    return np.asarray(turned.real / np.linalg.norm(turned.real, axis=0), float)


def _apart(shapes: Array, members: list[int]) -> Array | None:
    """Return what makes the members' modal coordinates of outputs, (members, outputs), or None."""
    outputs, modes = shapes.shape
    for chosen in (list(range(modes)), members):
        some = shapes[:, chosen]
        if len(chosen) <= outputs and np.linalg.svd(some)[1][-1] > DISTINCT:
            return np.asarray(np.linalg.pinv(some)[[chosen.index(i) for i in members]], float)
    return None


def _same(found: Likeliest, modal: ModalModel, members: list[int]) -> bool:
    """Whether the refined modes are still those that the subspace method found."""
    f, zeta = modal.natural_freq[members], modal.damping_ratio[members]
    near = np.abs(found.frequency_hz - f) < np.maximum(found.damping, zeta) * f
    return bool(np.all(near) and np.all(found.std[1] < found.damping))
