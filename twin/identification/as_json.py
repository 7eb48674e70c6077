"""An identification as the JSON of the command line's contract."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.identification.result import Identification

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


def _item(values: Array | None, index: int) -> float | None:
    return None if values is None else float(values[index])


def _matrix(values: Array | None) -> list[list[float]] | None:
    return None if values is None else np.asarray(values).tolist()
