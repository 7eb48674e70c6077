"""Recordings as CSV: one header row of ``name [unit]``, then one row a sample.

The reader also takes files of others: separated by commas, semicolons or tabs, with quoted
headers, without units, with a trailing separator in every row, or with columns that hold only
their first value; then a channel map says what is what.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError
from twin.formats.csv_cells import read_cells, split_row
from twin.formats.table import Column, Table
from twin.formats.text import header_text, text_of
from twin.recording import Recording
from twin.units import split_name

Array = NDArray[np.float64]

SEPARATORS = ",;\t"


def read(path: Path) -> Table:
    """Read the header; the samples of the chosen columns are read when they are asked for.

    Raises:
        RecordingError: empty, not text, no header, or no samples.
    """
    head, body = text_of(path)
    header = header_text(head)
    separator = _separator(header)
    names = split_row(header, separator, f"{path}: row 1")
    cells = len(names)
    lines = body.split("\n")
    while lines and not lines[-1].strip(" \t" + separator):
        lines.pop()
    if _all_numbers(names):
        raise RecordingError(
            f"{path}: row 1 holds numbers where a header such as 'time [s],force_floor1 [N]' "
            "belongs"
        )
    first = split_row(lines[0], separator, f"{path}: row 2") if lines else []
    while names and not names[-1].strip():
        if len(first) >= len(names) and first[len(names) - 1].strip():
            raise RecordingError(f"{path}: column {len(names)} holds values but has no name")
        names.pop()
    if not names:
        raise RecordingError(f"{path}: row 1, where the header belongs, is empty")
    if not lines:
        raise RecordingError(f"{path}: a header but no samples")
    columns = tuple(Column(*split_name(name)) for name in names)
    load = partial(_load, str(path), lines, separator, columns, cells)
    return Table(str(path), columns, load, row="row", first_row=2)


def write(recording: Recording, path: Path) -> None:
    """Write with 17 significant digits where they are needed: reading gives the same numbers."""
    header = ["time [s]", *(channel.title for channel in recording.channels)]
    rows = np.column_stack([recording.time, recording.data]).tolist()
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerow(header)
        file.writelines(",".join(map(repr, row)) + "\n" for row in rows)


def _load(
    source: str,
    lines: list[str],
    separator: str,
    columns: tuple[Column, ...],
    cells: int,
    wanted: Sequence[int],
) -> list[Array]:
    """Read some columns: numpy's parser where every row is clean, else cell by cell."""
    separators = cells - 1
    if all(line.count(separator) == separators for line in lines):
        try:
            read = np.loadtxt(lines, delimiter=separator, usecols=wanted, comments=None, ndmin=2)
            if len(read) == len(lines):  # it skips empty lines
                return list(read.T)
        except ValueError:
            pass  # quoted numbers, or damage that is looked for below
    labels = [column.label for column in columns]
    return read_cells(source, lines, separator, labels, cells, wanted)


def _separator(header: str) -> str:
    """Return the separator that splits the header into most columns outside quotes."""

    def count(separator: str) -> int:
        try:
            return len(next(csv.reader([header], delimiter=separator)))
        except (csv.Error, StopIteration):
            return 0

    return max(SEPARATORS, key=count)


def _all_numbers(names: list[str]) -> bool:
    def is_number(text: str) -> bool:
        try:
            float(text)
        except ValueError:
            return False
        return True

    filled = [name for name in names if name.strip()]
    return bool(filled) and all(is_number(name) for name in filled)
