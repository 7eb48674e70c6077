"""Named arrays (MAT, NPZ, HDF5) as columns of a table, and a recording as named arrays.

Our own files hold one vector a channel and ``time``, the scalar ``sampling_hz``, and the units:
as a text array ``units`` with lines such as "acc_floor1 [m/s^2]" where a format has no attributes.
A channel whose name no variable can have ("A 3", "tip.y") is kept under one that can be, and its
own name stands beside it: the line is then "tip_y = tip.y [m/s^2]".
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError
from twin.formats.table import Column, Table, samples_of
from twin.recording import Recording
from twin.units import split_name

Array = NDArray[np.float64]

RATE = "sampling_hz"
UNITS = "units"

LONGEST_VARIABLE = 31
"""Letters of a variable's name in a MATLAB file of version 5."""

_OWN_NAME = re.compile(r"^([A-Za-z][A-Za-z0-9_]*) = (.*)$", re.DOTALL)

MOST_COLUMNS = 4096
"""A matrix with more columns than this on its shorter side is no recording."""


@dataclass(frozen=True)
class Entry:
    """One array of a file, described before it is loaded; ``variable`` is its name there."""

    name: str
    shape: tuple[int, ...]
    unit: str | None = None
    problem: str | None = None
    variable: str = ""


def table_of(
    path: Path,
    entries: Iterable[Entry],
    load: Callable[[str], Any],
    sampling_hz: float | None,
) -> Table:
    """Return a table: a vector is one column; a matrix one a column, or one a row if it is wide.

    Args:
        path: the file.
        entries: its arrays.
        load: returns an array by name.
        sampling_hz: rate that the file declares [Hz], or None.
    """
    columns: list[Column] = []
    places: list[tuple[str, int]] = []
    for entry in entries:
        for position, name in enumerate(_column_names(entry)):
            columns.append(Column(name, entry.unit, problem=entry.problem))
            places.append((entry.variable or entry.name, position))

    def load_columns(indices: Sequence[int]) -> list[Array]:
        loaded: dict[str, Any] = {}
        samples = []
        for index in indices:
            name, position = places[index]
            if name not in loaded:
                loaded[name] = load(name)
            samples.append(_series(loaded[name], position, f"{path}: column '{name}'"))
        return samples

    if not columns:
        raise RecordingError(f"{path}: holds no arrays")
    return Table(str(path), tuple(columns), load_columns, sampling_hz)


def variables_of(recording: Recording) -> dict[str, str]:
    """Return the name of each channel's variable: a letter, then letters, digits, underscores."""
    found: dict[str, str] = {}
    taken = {"time", RATE, UNITS, "file"}  # np.savez has an argument of that name
    for name in recording.names:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
        plain = (plain if plain[0].isalpha() else f"x{plain}")[:LONGEST_VARIABLE]
        variable, number = plain, 1
        while variable in taken:
            number += 1
            variable = f"{plain}_{number}"
        taken.add(variable)
        found[name] = variable
    return found


def arrays_of(recording: Recording) -> dict[str, Array]:
    """Return time and channels as vectors, and the sampling rate, by the variable's name."""
    variables = variables_of(recording)
    columns = {variables[c.name]: recording.data[:, i] for i, c in enumerate(recording.channels)}
    return {"time": recording.time, **columns, RATE: np.array(recording.sampling_hz)}


def unit_lines(recording: Recording) -> list[str]:
    """Return "time [s]" and the like for each of the vectors."""
    variables = variables_of(recording)
    lines = ["time [s]"]
    for channel in recording.channels:
        variable = variables[channel.name]
        own = "" if variable == channel.name else f"{variable} = "
        lines.append(f"{own}{channel.title}")
    return lines


def units_by_name(lines: Any) -> Mapping[str, tuple[str, str | None]]:
    """Read what ``unit_lines`` wrote: variable -> name and unit."""
    found = {}
    for line in np.atleast_1d(lines):
        match = _OWN_NAME.match(str(line))
        variable, title = (match[1], match[2]) if match else (None, str(line))
        name, unit = split_name(title)
        found[variable or name] = (name, unit)
    return found


def described(
    variable: str, shape: tuple[int, ...], problem: str | None,
    units: Mapping[str, tuple[str, str | None]],
) -> Entry:  # fmt: skip
    """Return an array's entry under the channel's own name."""
    name, unit = units.get(variable, (variable, None))
    return Entry(name, shape, unit, problem, variable)


def scalar(value: Any, what: str) -> float:
    """Return a rate kept as an array of one number. Raises RecordingError for anything else."""
    numbers = samples_of(value, what)
    if len(numbers) != 1 or not (np.isfinite(numbers[0]) and numbers[0] > 0):
        raise RecordingError(f"{what} is not one positive number")
    return float(numbers[0])


def _column_names(entry: Entry) -> list[str]:
    """Name the series as MATLAB writes them: a, or a(:,1), a(:,2), or a(1,:), a(2,:)."""
    sizes = [size for size in entry.shape if size != 1]
    if len(sizes) < 2 or entry.problem or min(sizes) > MOST_COLUMNS or len(entry.shape) != 2:
        return [entry.name]
    rows, columns = entry.shape
    if rows >= columns:
        return [f"{entry.name}(:,{k + 1})" for k in range(columns)]
    return [f"{entry.name}({k + 1},:)" for k in range(rows)]


def _series(values: Any, position: int, what: str) -> Array:
    array = np.asarray(values)
    sizes = [size for size in array.shape if size != 1]
    if len(sizes) < 2:
        return samples_of(array, what)
    if array.ndim != 2 or min(sizes) > MOST_COLUMNS:
        raise RecordingError(f"{what} has the shape {array.shape}, which is no set of channels")
    tall = array.shape[0] >= array.shape[1]
    return samples_of(array[:, position] if tall else array[position], what)
