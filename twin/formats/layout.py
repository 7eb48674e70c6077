"""How a text file is laid out: its separator, its header, units and where the samples begin."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass

from twin.errors import RecordingError
from twin.formats.clock import is_clock
from twin.formats.csv_cells import split_row
from twin.units import is_unit, quantity_of, split_name

SEPARATORS = ",;\t|"

LONGEST_PREAMBLE = 200
"""Lines before the header that a measuring program may write about the measurement."""

_DECLARED = re.compile(r"^sep=(.)$", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"^[+-]?\d*,\d+(?:[eE][+-]?\d+)?$|^[+-]?\d+,\d*$")
_IN_PARENTHESES = re.compile(r"^(.*\S)\s*\(([^()]+)\)$")
_AMBIGUOUS = ("A", "B", "C", "L", "R", "T")
"""Letters in parentheses that number a sensor as often as they are a unit."""


@dataclass(frozen=True)
class Layout:
    """Where things stand in a text file.

    Attributes:
        titles: the header's cells, with a unit in brackets where one is given.
        separator: between cells.
        cells: how many the header has.
        header: index of the header's line.
        first: index of the first line of samples.
        decimal_comma: whether decimals are written with a comma.
    """

    titles: tuple[str, ...]
    separator: str
    cells: int
    header: int
    first: int
    decimal_comma: bool


def layout_of(lines: list[str], source: str) -> Layout:
    """Find header, units and samples.

    Usually the first line is the header. A measuring program may write lines about the measurement
    before it, a line of units after it, or "sep=;"; the header may stand in a comment ("# time").

    Args:
        lines: of the file.
        source: the file, as messages name it.

    Raises:
        RecordingError: quotes in the header that do not close.
    """
    start, separator = 0, None
    if lines and (declared := _DECLARED.match(lines[0].strip())):
        start, separator = 1, declared[1]
    header = start
    if not _header_at(lines, start, separator or _separator(lines[start])):
        found = (
            at
            for at in range(start + 1, min(start + LONGEST_PREAMBLE, len(lines) - 1))
            if _header_at(lines, at, separator or _separator(lines[at]))
        )
        header = next(found, start)
    separator = separator or _separator(lines[header])
    where = f"{source}: row {header + 1}"
    line = lines[header]
    if header > start or _numeric_row(_after(lines, header, separator)):
        line = re.sub(r"^\s*[#%]+\s*", "", line)
    titles = split_row(line, separator, where)
    first = header + 1
    if _units_row(titles, lines, first, separator):
        units = split_row(lines[first], separator, f"{source}: row {first + 1}")
        titles = [
            f"{t} [{_bare(u)}]" if _bare(u) else t for t, u in zip(titles, units, strict=True)
        ]
        first += 1
    titles = [_with_brackets(title) for title in titles]
    cells = _after(lines, first - 1, separator)
    comma = separator != "," and any(_DECIMAL_COMMA.match(c.strip()) for c in cells)
    return Layout(tuple(titles), separator, len(titles), header, first, comma)


def is_number(text: str) -> bool:
    """Return whether this is a number, its decimals behind a point or a comma."""
    text = text.strip()
    try:
        float(text)
    except ValueError:
        return bool(_DECIMAL_COMMA.match(text))
    return "_" not in text


def _separator(line: str) -> str:
    """Return the separator that splits a line into most cells outside quotes."""

    def count(separator: str) -> int:
        try:
            return len(next(csv.reader([line], delimiter=separator)))
        except (csv.Error, StopIteration):
            return 0

    return max(SEPARATORS, key=count)


def _cells(line: str, separator: str) -> list[str]:
    try:
        return split_row(line, separator, "")
    except RecordingError:
        return []


def _after(lines: list[str], row: int, separator: str) -> list[str]:
    return _cells(lines[row + 1], separator) if row + 1 < len(lines) else []


def _header_at(lines: list[str], row: int, separator: str) -> bool:
    """Return whether a line of names, then perhaps one of units, then numbers begins here."""
    names = _cells(lines[row], separator)
    if len(names) < 2 or any(is_number(name) for name in names if name.strip()):
        return False
    below = _after(lines, row, separator)
    if len(below) == len(names) and not _numeric_row(below):
        below = _after(lines, row + 1, separator)
    return len(below) == len(names) and _numeric_row(below)


def _numeric_row(cells: list[str]) -> bool:
    """Return whether the first filled cells are numbers or times: notes may stand behind them."""
    filled = [cell for cell in cells if cell.strip()]
    return bool(filled) and (is_number(filled[0]) or is_clock(filled[0]))


def _units_row(titles: list[str], lines: list[str], row: int, separator: str) -> bool:
    """Return whether a line holds units and the one after it the first samples."""
    if row + 1 >= len(lines):
        return False
    cells = _cells(lines[row], separator)
    if len(cells) != len(titles) or any(is_number(cell) for cell in cells if cell.strip()):
        return False
    if any(split_name(title)[1] for title in titles):
        return False
    filled = [unit for unit in (_bare(cell) for cell in cells) if unit]
    below = _cells(lines[row + 1], separator)
    return (
        len(filled) > 0
        and len(below) == len(cells)
        and _numeric_row(below)
        and all(unit in ("s", "ms") or is_unit(unit) for unit in filled)
    )


def _bare(unit: str) -> str:
    """Return a unit without the brackets around it."""
    return re.sub(r"^[\[(]\s*(.*?)\s*[\])]$", r"\1", unit.strip())


def _with_brackets(title: str) -> str:
    """Return "force [N]" for "force (N)", where what stands in parentheses is a unit."""
    match = _IN_PARENTHESES.match(title.strip())
    if not match or match[2] in _AMBIGUOUS or split_name(title)[1] is not None:
        return title
    if match[2].strip() in ("s", "ms", "us", "µs", "sec"):
        return f"{match[1]} [{match[2].strip()}]"
    try:
        kind = quantity_of(match[2].strip(), "")[0]
    except RecordingError:
        return title
    return title if kind == "other" else f"{match[1]} [{match[2].strip()}]"
