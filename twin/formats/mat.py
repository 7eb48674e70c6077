"""Recordings as MATLAB files up to version 7, through scipy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from twin.errors import RecordingError
from twin.formats.mat_elements import check_elements
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

NUMERIC = {
    *("double", "single", "logical"),
    *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)),
}
"""MATLAB's classes of numbers; everything else (cell, struct, object, char) is refused."""


def read(path: Path) -> Table:
    """List the variables; those that are wanted are loaded when they are asked for.

    Raises:
        RecordingError: damaged, or of version 7.3 (which is HDF5).
    """
    from scipy import io

    with path.open("rb") as file:
        if file.read(19).startswith(b"MATLAB 7.3 MAT-file"):
            raise RecordingError(
                f"{path}: a MATLAB 7.3 file is HDF5; rename it to {path.stem}.h5, "
                "or save it with -v7"
            )
    with decoding(path, "MAT"):
        check_elements(path)
        listed = io.whosmat(path)
    classes = {name: kind for name, _, kind in listed}

    def load(name: str) -> Any:
        with decoding(path, "MAT"):
            return io.loadmat(path, variable_names=[name])[name]

    units = units_by_name(load(UNITS)) if classes.get(UNITS) == "char" else {}
    rate = scalar(load(RATE), f"{path}: variable '{RATE}'") if RATE in classes else None
    entries = [
        described(name, tuple(shape), _problem(kind), units)
        for name, shape, kind in listed
        if not (name == RATE or (name == UNITS and kind == "char"))
    ]
    return table_of(path, entries, load, rate)


def write(recording: Recording, path: Path) -> None:
    """Write one column vector a channel, with the units in the text variable ``units``."""
    from scipy import io

    variables: dict[str, Any] = dict(arrays_of(recording))
    variables[UNITS] = unit_lines(recording)
    io.savemat(path, variables, oned_as="column")


def _problem(kind: str) -> str | None:
    return None if kind in NUMERIC else f"is a MATLAB {kind}, not an array of numbers"
