"""Identified against true parameters as rows, which tables, figures and Rerun print alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from twin.errors import ModelError
from twin.identification.result import Identification
from twin.modal import ModalModel, mac
from twin.model import Twin
from twin.place import split_channel
from twin.second_order import SecondOrderModel

Array = NDArray[np.float64]

SAME_MODE = 0.3
"""Modes are paired when their frequencies differ by less than this share."""


@dataclass(frozen=True)
class Row:
    """One parameter.

    Attributes:
        quantity: what it is ("frequency 1", "K12").
        unit: SI unit, or "%" for a damping ratio; "" for a bare number.
        identified: its estimate, in ``unit``.
        std: standard deviation, or None.
        bound: Cramer-Rao bound of the standard deviation, or None.
        true: true value, or None.
    """

    quantity: str
    unit: str
    identified: float
    std: float | None = None
    bound: float | None = None
    true: float | None = None

    @property
    def error(self) -> float | None:
        """Identified less true over true, or None."""
        if self.true is None or self.true == 0:
            return None
        return (self.identified - self.true) / abs(self.true)

    @property
    def error_in_std(self) -> float | None:
        """Identified less true in standard deviations, or None."""
        if self.true is None or not self.std:
            return None
        return (self.identified - self.true) / self.std


def place_of(output: str) -> str:
    """Return "floor1" for both "acc_floor1" and "floor1"."""
    parts = split_channel(output)
    return str(parts[1]) if parts else output


def paired_modes(identified: ModalModel, truth: ModalModel | None) -> tuple[int | None, ...]:
    """Return for each identified mode the index of the true mode it belongs to, or None."""
    count = len(identified.natural_freq)
    pairs: list[int | None] = [None] * count
    if truth is None or not len(truth.natural_freq) or not count:
        return tuple(pairs)
    distance = np.abs(np.log(identified.natural_freq[:, None] / truth.natural_freq[None, :]))
    unlike = np.zeros(distance.shape)
    mine, theirs = same_rows(identified, truth)
    if len(mine) > 1:
        # Of modes close by, the shape says which is which.
        unlike = 1 - mac(identified.mode_shape[mine], truth.mode_shape[theirs])
    far = distance / np.log1p(SAME_MODE)
    for i, j in zip(*linear_sum_assignment(np.minimum(far, 10) + unlike), strict=True):
        if distance[i, j] < np.log1p(SAME_MODE):
            pairs[i] = int(j)
    return tuple(pairs)
    distance = np.abs(np.log(identified.natural_freq[:, None] / truth.natural_freq[None, :]))
    for mine, theirs in zip(*linear_sum_assignment(distance), strict=True):
        if distance[mine, theirs] < np.log1p(SAME_MODE):
            pairs[mine] = int(theirs)
    return tuple(pairs)


def modal_rows(identification: Identification, truth: ModalModel | None) -> tuple[Row, ...]:
    """Return frequency, damping ratio and, where a truth is known, MAC of every identified mode."""
    modal = identification.modal
    pairs = paired_modes(modal, truth)
    rows = []
    for r, pair in enumerate(pairs):
        name = f"frequency {r + 1}"
        true = None if truth is None or pair is None else float(truth.natural_freq[pair])
        rows.append(
            Row(
                name,
                "Hz",
                float(modal.natural_freq[r]),
                _at(modal.natural_freq_std, r),
                _at(identification.natural_freq_bound, r),
                true,
            )
        )
    for r, pair in enumerate(pairs):
        name = f"damping {r + 1}"
        true = None if truth is None or pair is None else 100 * float(truth.damping_ratio[pair])
        rows.append(
            Row(
                name,
                "%",
                100 * float(modal.damping_ratio[r]),
                _at(modal.damping_ratio_std, r, 100),
                _at(identification.damping_ratio_bound, r, 100),
                true,
            )
        )
    for r, pair in enumerate(pairs):
        same = None if truth is None or pair is None else _mac(modal, r, truth, pair)
        if same is not None:
            rows.append(Row(f"MAC {r + 1}", "", same))
    return tuple(rows)


def mode_rows(modal: ModalModel) -> list[Row]:
    """Return frequency and damping ratio of every mode, with their standard deviations."""
    rows = []
    for i, (f, z) in enumerate(zip(modal.natural_freq, modal.damping_ratio, strict=True)):
        rows.append(Row(f"frequency {i + 1}", "Hz", float(f), _at(modal.natural_freq_std, i)))
        spread = _at(modal.damping_ratio_std, i, 100)
        rows.append(Row(f"damping {i + 1}", "%", 100 * float(z), spread))
    return rows


def proportional(result: Identification) -> tuple[float, float] | None:
    """Return alpha [1/s] and beta [s] of eq. (43); None where they would be a negative damping."""
    alpha, beta = result.alpha, result.beta
    return None if alpha is None or beta is None or min(alpha, beta) < 0 else (alpha, beta)


def matrices_of(truth: Twin | None) -> SecondOrderModel | None:
    """Return M, R, K of the true model; None of a structure that is no chain of floors."""
    if truth is None:
        return None
    try:
        return truth.second_order()
    except ModelError:
        return None


def matrix_rows(
    identified: SecondOrderModel | None,
    truth: SecondOrderModel | None,
    std: SecondOrderModel | None = None,
) -> tuple[Row, ...]:
    """Return the entries of M and K on and above the diagonal; () where none were identified."""
    if identified is None:
        return ()
    places = [place_of(name) for name in identified.coordinates]
    rows = []
    for letter, unit in (("M", "kg"), ("K", "N/m")):
        mine = getattr(identified, letter)
        theirs = _same_coordinates(truth, places, letter)
        for i in range(len(places)):
            for j in range(i, len(places)):
                true = None if theirs is None else float(theirs[i, j])
                spread = None if std is None else float(getattr(std, letter)[i, j])
                name = f"{letter}{i + 1}{j + 1}"
                rows.append(Row(name, unit, float(mine[i, j]), spread, true=true))
    return tuple(rows)


def _same_coordinates(
    truth: SecondOrderModel | None, places: Sequence[str], letter: str
) -> Array | None:
    if truth is None or sorted(truth.coordinates) != sorted(places):
        return None
    order = [truth.coordinates.index(place) for place in places]
    return np.asarray(getattr(truth, letter)[np.ix_(order, order)])


def _at(values: Array | None, index: int, scale: float = 1.0) -> float | None:
    return None if values is None else scale * float(values[index])


def same_rows(a: ModalModel, b: ModalModel) -> tuple[Array, Array]:
    """Return the rows of two models' shapes that belong together, (common,) each.

    Sensors of one name do; where there is none, what stands at the same places.
    """
    common = [(row, b.outputs.index(name)) for row, name in enumerate(a.outputs)
              if name in b.outputs]  # fmt: skip
    if not common:
        theirs = {place_of(name): row for row, name in enumerate(b.outputs)}
        common = [
            (row, theirs[place_of(name)])
            for row, name in enumerate(a.outputs)
            if place_of(name) in theirs
        ]
    mine, other = (np.array([pair[k] for pair in common], int) for k in (0, 1))
    return mine, other


def _mac(a: ModalModel, mode_a: int, b: ModalModel, mode_b: int) -> float | None:
    mine, other = same_rows(a, b)
    if len(mine) < 2:
        return None
    return float(
        mac(a.mode_shape[mine, mode_a][:, None], b.mode_shape[other, mode_b][:, None])[0, 0]
    )
