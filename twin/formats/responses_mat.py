"""Measured frequency responses as MATLAB files up to version 7."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError
from twin.formats.mat_elements import check_elements
from twin.formats.response_pairs import Measured
from twin.formats.table import decoding

Array = NDArray[np.float64]

RESPONSE = ("H", "frf", "FRF")
FREQUENCY = ("f", "freq", "frequency", "frequency_hz")
COHERENCE = ("coherence", "coh", "C")
NAMES = ("outputs", "inputs")
"""Variables by the names under which they may stand."""


def holds(path: Path) -> bool:
    """Whether the file has variables named as a response and as its frequencies."""
    from scipy import io

    with path.open("rb") as file:
        if file.read(19).startswith(b"MATLAB 7.3 MAT-file"):
            return False
    with decoding(path, "MAT"):
        names = {name for name, _, _ in io.whosmat(path)}
    return all(names.intersection(known) for known in (RESPONSE, FREQUENCY))


def read(path: Path) -> Measured:
    """Read frequencies, responses and, where it has them, coherence and names.

    Raises:
        RecordingError: shapes that do not fit together.
    """
    from scipy import io

    wanted = [*RESPONSE, *FREQUENCY, *COHERENCE, *NAMES]
    with decoding(path, "MAT"):
        check_elements(path)
        loaded = io.loadmat(path, variable_names=wanted)
    f = np.real(_numbers(path, loaded, FREQUENCY)).ravel()
    H = _of_lines(_numbers(path, loaded, RESPONSE), len(f), path, "the response")
    names = [_names(loaded.get(key), size) for key, size in zip(NAMES, H.shape[1:], strict=True)]
    found = Measured(f)
    known = None
    if any(name in loaded for name in COHERENCE):
        values = np.real(_numbers(path, loaded, COHERENCE))
        known = _of_lines(values, len(f), path, "the coherence")
        try:
            known = np.broadcast_to(known, H.shape)
        except ValueError:
            raise RecordingError(
                f"{path}: a coherence of shape {known.shape} for responses of shape {H.shape}"
            ) from None
    for o, output in enumerate(names[0]):
        for i, driven in enumerate(names[1]):
            found.H[output, driven] = np.asarray(H[:, o, i], complex)
            if known is not None:
                found.coherence[output, driven] = np.asarray(known[:, o, i], float)
    return found


def _numbers(path: Path, loaded: dict[str, Any], names: tuple[str, ...]) -> NDArray[Any]:
    name = next((n for n in names if n in loaded), None)
    if name is None:
        raise RecordingError(f"{path}: no variable {' or '.join(names)}")
    values = np.asarray(loaded[name])
    if values.dtype.kind not in "iufc":
        raise RecordingError(f"{path}: variable '{name}' does not hold numbers")
    return values


def _of_lines(values: NDArray[Any], lines: int, path: Path, what: str) -> NDArray[Any]:
    """Return (lines, outputs, inputs), whichever of the axes has as many entries as lines."""
    if values.ndim == 2:
        if values.shape[0] != lines and values.shape[1] == lines:
            values = values.T
        values = values[:, :, None]
    if values.ndim == 3 and values.shape[0] != lines and values.shape[2] == lines:
        values = values.transpose(2, 0, 1)
    if values.ndim != 3 or values.shape[0] != lines:
        raise RecordingError(
            f"{path}: {what} has the shape {values.shape}; {lines} frequencies ask for "
            f"({lines}, outputs, inputs)"
        )
    return values


def _names(value: Any, count: int) -> list[str]:
    given = [str(np.squeeze(v)).strip() for v in np.ravel(value)] if value is not None else []
    return given if len(given) == count else [str(k + 1) for k in range(count)]
