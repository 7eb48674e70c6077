"""An identification as the JSON of the command line's contract."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.identification.result import Identification
from twin.modal import ModalModel

Array = NDArray[np.float64]


def as_json(result: Identification) -> dict[str, Any]:
    """Return the contract's dictionary; null where the notes say why something is missing."""
    modal, second_order, model = result.modal, result.second_order, result.state_space
    spread = result.second_order_std
    modes = []
    for i in range(len(modal.natural_freq)):
        modes.append(
            {
                "frequency_hz": float(modal.natural_freq[i]),
                "frequency_std_hz": _item(modal.natural_freq_std, i),
                "frequency_bound_hz": _item(result.natural_freq_bound, i),
                "damping_ratio": float(modal.damping_ratio[i]),
                "damping_std": _item(modal.damping_ratio_std, i),
                "damping_bound": _item(result.damping_ratio_bound, i),
                "shape": modal.amplitude[:, i].tolist(),
                "phase_rad": modal.phase[:, i].tolist(),
            }
        )
    return {
        "modes": modes,
        "singular_values": result.singular_values.tolist() or None,
        "order": result.order,
        "A": _matrix(model.A),
        "B": _matrix(model.B),
        "C": _matrix(model.C),
        "D": _matrix(model.D),
        "G": _matrix(model.G),
        "M": _matrix(second_order.M if second_order else None),
        "K": _matrix(second_order.K if second_order else None),
        "R": _matrix(second_order.R if second_order else None),
        "M_std": _matrix(spread.M if spread else None),
        "K_std": _matrix(spread.K if spread else None),
        "R_std": _matrix(spread.R if spread else None),
        "alpha": result.alpha,
        "beta": result.beta,
        "coordinates": list(second_order.coordinates) if second_order else None,
        "outputs": list(result.outputs),
        "inputs": list(result.inputs),
        "sampling_hz": result.sampling_hz,
        "route": result.route,
        "nrmse": result.nrmse,
        "notes": list(result.notes),
    }


def modes_as_json(
    modal: ModalModel, inputs: Sequence[str], sampling_hz: float, order: int, notes: Sequence[str]
) -> dict[str, Any]:
    """Return the contract's dictionary of modes alone, null for what only records give.

    Args:
        modal: the modes with their standard deviations.
        inputs: driven points; none where only the response was measured.
        sampling_hz: of the records, or twice the highest line and more of a response [Hz].
        order: number of states behind the modes.
        notes: what a reader has to know.
    """
    modes = [
        {
            "frequency_hz": float(modal.natural_freq[i]),
            "frequency_std_hz": _item(modal.natural_freq_std, i),
            "damping_ratio": float(modal.damping_ratio[i]),
            "damping_std": _item(modal.damping_ratio_std, i),
            "shape": modal.amplitude[:, i].tolist(),
            "phase_rad": modal.phase[:, i].tolist(),
        }
        for i in range(len(modal.natural_freq))
    ]
    none = ("singular_values", "A", "B", "C", "D", "G", "M", "K", "R", "alpha", "beta")
    return {
        "modes": modes,
        **dict.fromkeys(none),
        "order": order,
        "outputs": list(modal.outputs),
        "inputs": list(inputs),
        "sampling_hz": sampling_hz,
        "notes": list(notes),
    }


def _item(values: Array | None, index: int) -> float | None:
    return None if values is None else float(values[index])


def _matrix(values: Array | None) -> list[list[float]] | None:
    return None if values is None else np.asarray(values).tolist()
