"""Recordings as CSV: one header row of ``name [unit]``, then one row a sample.

The reader also takes files of others: separated by commas, semicolons, tabs or spaces, with
decimal commas, with quoted headers, with lines about the measurement before the header or a line
of units after it, without units, with a trailing separator in every row, with times of day, or with
columns that hold only their first value; then a channel map says what is what.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError
from twin.formats.clock import is_clock
from twin.formats.csv_cells import Rows, read_cells, split_row
from twin.formats.layout import SEPARATORS, is_number, layout_of
from twin.formats.table import Column, Table
from twin.formats.text import text_of
from twin.recording import Recording
from twin.units import split_name

Array = NDArray[np.float64]

_WORD = re.compile(r"\S+(?:\s*\[[^\[\]]*\])?")


def read(path: Path) -> Table:
    """Read the header; the samples of the chosen columns are read when they are asked for.

    Raises:
        RecordingError: empty, not text, no header, or no samples.
    """
    return table_of_text(text_of(path), str(path))


def table_of_text(text: str, source: str) -> Table:
    """Find header and samples in a text; the chosen columns are read when they are asked for.

    Raises:
        RecordingError: no header, or no samples.
    """
    lines = _spaced(text.split("\n"))
    layout = layout_of(lines, source)
    separator, names = layout.separator, list(layout.titles)
    while len(lines) > layout.first and not lines[-1].strip(" \t" + separator):
        lines.pop()
    where = f"{source}: row {layout.header + 1}"
    filled = [name for name in names if name.strip()]
    if filled and all(is_number(name) for name in filled):
        raise RecordingError(
            f"{where} holds numbers where a header such as 'time [s],force_floor1 [N]' belongs"
        )
    # the numbers are ASCII; anything else becomes a cell that is refused by name
    body = [line.encode("ascii", "replace").decode() for line in lines[layout.first :]]
    first = split_row(body[0], separator, f"{source}: row {layout.first + 1}") if body else []
    while names and not names[-1].strip():
        if len(first) >= len(names) and first[len(names) - 1].strip():
            raise RecordingError(f"{source}: column {len(names)} holds values but has no name")
        names.pop()
    if not names:
        raise RecordingError(f"{where}, where the header belongs, is empty")
    if not body:
        raise RecordingError(f"{source}: a header but no samples")
    clocks = frozenset(i for i, cell in enumerate(first[: len(names)]) if is_clock(cell))
    columns = tuple(Column(*split_name(name)) for name in names)
    columns = tuple(
        replace(column, unit="s") if index in clocks and column.unit is None else column
        for index, column in enumerate(columns)
    )
    labels = tuple(column.label for column in columns)
    rows = Rows(
        source, body, separator, labels, layout.cells, layout.first, layout.decimal_comma, clocks
    )
    load = partial(_load, rows)
    return Table(source, columns, load, row="row", first_row=layout.first + 1)


def write(recording: Recording, path: Path) -> None:
    """Write with 17 significant digits where they are needed: reading gives the same numbers."""
    header = ["time [s]", *(channel.title for channel in recording.channels)]
    rows = np.column_stack([recording.time, recording.data]).tolist()
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerow(header)
        file.writelines(",".join(map(repr, row)) + "\n" for row in rows)


def _load(rows: Rows, wanted: Sequence[int]) -> list[Array]:
    """Read some columns: numpy's parser where every row is clean, else cell by cell."""
    lines, separator = rows.lines, rows.separator
    if rows.decimal_comma and not any("." in line for line in lines):
        lines = [line.replace(",", ".") for line in lines]
    separators = rows.cells - 1
    if not rows.clocks & set(wanted) and all(line.count(separator) == separators for line in lines):
        try:
            read = np.loadtxt(lines, delimiter=separator, usecols=wanted, comments=None, ndmin=2)
            if len(read) == len(lines):  # it skips empty lines
                return list(read.T)
        except ValueError:
            pass  # quoted numbers, or damage that is looked for below
    return read_cells(rows, wanted)


def _spaced(lines: list[str]) -> list[str]:
    """Return lines whose columns are separated by spaces with tabs between them instead."""
    head = lines[0]
    body = [line for line in lines[1:] if line.strip()]
    if not body or any(mark in line for mark in SEPARATORS for line in (head, body[0], body[-1])):
        return lines
    names, first = _WORD.findall(head.lstrip("#% ")), body[0].split()
    if len(names) < 2 or len(names) != len(first) or not all(map(is_number, first)):
        return lines
    return ["\t".join(names), *("\t".join(line.split()) for line in lines[1:])]
