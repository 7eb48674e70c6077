"""Recordings as NumPy files; pickled objects are refused, because loading them runs code."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from twin.errors import RecordingError
from twin.formats.named_arrays import (
    RATE,
    UNITS,
    arrays_of,
    described,
    scalar,
    table_of,
    unit_lines,
    units_by_name,
)
from twin.formats.table import Table, decoding
from twin.recording import Recording


def read(path: Path) -> Table:
    """Read an .npz file of named vectors, or an .npy file whose columns a map names.

    Raises:
        RecordingError: damaged, or with pickled objects.
    """
    with decoding(path, "NumPy"):
        arrays = _arrays(path)
    units = units_by_name(arrays[UNITS]) if _is_text(arrays.get(UNITS)) else {}
    rate = scalar(arrays[RATE], f"{path}: array '{RATE}'") if RATE in arrays else None
    entries = [
        described(name, array.shape, _problem(array), units)
        for name, array in arrays.items()
        if not (name == RATE or (name == UNITS and _is_text(array)))
    ]
    return table_of(path, entries, arrays.__getitem__, rate)


def write(recording: Recording, path: Path) -> None:
    """Write an .npz file: one vector a channel, with the units in the array ``units``."""
    arrays: dict[str, Any] = dict(arrays_of(recording))
    with path.open("wb") as file:
        np.savez_compressed(file, **arrays, units=np.array(unit_lines(recording)))


def _arrays(path: Path) -> dict[str, Any]:
    """Load all arrays, none of them by unpickling."""
    try:
        with path.open("rb") as file:
            loaded = np.load(file, allow_pickle=False)
            if isinstance(loaded, np.ndarray):
                names = loaded.dtype.names
                return {name: loaded[name] for name in names} if names else {"data": loaded}
            with loaded:
                return {name: np.asarray(loaded[name]) for name in loaded.files}
    except ValueError as error:
        if "allow_pickle" in str(error):
            raise RecordingError(
                f"{path}: pickled Python objects are refused, because loading them runs code; "
                "save plain arrays"
            ) from None
        raise


def _is_text(array: Any) -> bool:
    return array is not None and array.dtype.kind == "U"


def _problem(array: Any) -> str | None:
    return None if array.dtype.kind in "iubf" else f"holds {array.dtype}, not real numbers"
