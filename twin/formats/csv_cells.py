"""CSV files read cell by cell: slower, and each complaint names its row and column."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError
from twin.formats.clock import seconds_of
from twin.units import shown

Array = NDArray[np.float64]

CUT = "; cut the file there into two recordings, or fill the gap"
COMMA_TWICE = "; decimal commas need semicolons or tabs between the cells"
_FORTRAN = re.compile(r"^([+-]?[\d.]+)[dD]([+-]?\d+)$")


@dataclass(frozen=True)
class Rows:
    """The samples of a text file, not yet read.

    Attributes:
        source: the file, as messages name it.
        lines: the rows after the header.
        separator: between cells.
        labels: the columns, as messages name them.
        cells: how many cells the header has.
        before: how many lines stand before the first sample.
        decimal_comma: whether decimals are written with a comma.
        clocks: the columns that hold times of day.
    """

    source: str
    lines: list[str]
    separator: str
    labels: tuple[str, ...]
    cells: int
    before: int = 1
    decimal_comma: bool = False
    clocks: frozenset[int] = frozenset()


def split_row(line: str, separator: str, where: str) -> list[str]:
    """Split one row into its cells. Raises RecordingError when its quotes do not close."""
    try:
        rows = list(csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True))
    except csv.Error as error:
        raise RecordingError(f"{where} cannot be split into cells ({error})") from None
    return rows[0] if rows else []


def read_cells(rows: Rows, wanted: Sequence[int]) -> list[Array]:
    """Return the wanted columns.

    Raises:
        RecordingError: a row with more or fewer cells than the header, or a cell without a
            number.
    """
    values = np.empty((len(wanted), len(rows.lines)))
    clocks: dict[int, list[str]] = {index: [] for index in wanted if index in rows.clocks}
    for number, line in enumerate(rows.lines):
        where = f"{rows.source}: row {number + rows.before + 1}"
        row = split_row(line, rows.separator, where)
        if not line.strip():
            raise RecordingError(f"{where} is empty")
        if len(row) != rows.cells:
            hint = COMMA_TWICE if len(row) == 2 * rows.cells and rows.separator == "," else ""
            raise RecordingError(
                f"{where} has {len(row)} cells where the header has {rows.cells}{hint}"
            )
        for position, index in enumerate(wanted):
            column = f"{where}, column {rows.labels[index]}"
            if index in clocks:
                clocks[index].append(_clock(row[index], column))
            else:
                values[position, number] = _number(row[index], column, rows.decimal_comma)
    for position, index in enumerate(wanted):
        if index in clocks:
            values[position] = seconds_of(clocks[index])
    return list(values)


def _clock(cell: str, where: str) -> str:
    try:
        seconds_of([cell])
    except ValueError:
        raise RecordingError(
            f"{where}: {shown(cell.strip())} is not a time such as 12:30:01.25 or "
            "2026-05-01T12:30:01.25"
        ) from None
    return cell


def _number(cell: str, where: str, decimal_comma: bool) -> float:
    text = cell.strip()
    if not text:
        raise RecordingError(f"{where}: the cell is empty{CUT}")
    try:
        if "_" in text:  # Python would read 1_0 as ten
            raise ValueError
        if decimal_comma and "." not in text:
            return float(text.replace(",", "."))
        return float(_FORTRAN.sub(r"\1e\2", text))
    except ValueError:
        hint = "; decimals are written with a point" if "," in text else ""
        if hint and "." in text:
            hint = "; write it without separators of thousands"
        raise RecordingError(f"{where}: {shown(text)} is not a number{hint}") from None
