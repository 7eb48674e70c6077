"""CSV files read cell by cell: slower, and each complaint names its row and column."""

from __future__ import annotations

import csv
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError
from twin.units import shown

Array = NDArray[np.float64]


def split_row(line: str, separator: str, where: str) -> list[str]:
    """Split one row into its cells. Raises RecordingError when its quotes do not close."""
    try:
        rows = list(csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True))
    except csv.Error as error:
        raise RecordingError(f"{where} cannot be split into cells ({error})") from None
    return rows[0] if rows else []


def read_cells(
    source: str,
    lines: list[str],
    separator: str,
    labels: list[str],
    cells: int,
    wanted: Sequence[int],
) -> list[Array]:
    """Return the wanted columns.

    Args:
        source: the file, as messages name it.
        lines: the rows after the header.
        separator: between cells.
        labels: the columns, as messages name them.
        cells: how many cells the header has.
        wanted: indices of the columns.

    Raises:
        RecordingError: a row with more or fewer cells than the header, or a cell without a
            number.
    """
    values = np.empty((len(wanted), len(lines)))
    for number, line in enumerate(lines):
        where = f"{source}: row {number + 2}"
        row = split_row(line, separator, where)
        if not line.strip():
            raise RecordingError(f"{where} is empty")
        if len(row) != cells:
            raise RecordingError(f"{where} has {len(row)} cells where the header has {cells}")
        for position, index in enumerate(wanted):
            values[position, number] = _number(row[index], f"{where}, column {labels[index]}")
    return list(values)


def _number(cell: str, where: str) -> float:
    text = cell.strip()
    if not text:
        raise RecordingError(f"{where}: the cell is empty")
    try:
        if "_" in text:  # Python would read 1_0 as ten
            raise ValueError
        return float(text)
    except ValueError:
        hint = "; decimals are written with a point" if "," in text else ""
        raise RecordingError(f"{where}: {shown(text)} is not a number{hint}") from None
