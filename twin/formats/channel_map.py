"""Which column of a foreign file becomes which channel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from twin.channel import Channel, channel_in, implied_kind
from twin.errors import RecordingError
from twin.formats.table import Column, Table
from twin.units import EXAMPLES, shown, si_factor, split_name

TIME = "time"

TIME_UNITS = ("s", "sec", "ms", "us", "µs", "min", "h")
"""Units that make the first column the time, whatever it is called."""


@dataclass(frozen=True)
class Assignment:
    """One column in use.

    Attributes:
        index: which column of the table.
        channel: what it becomes, or None for the time.
        factor: what its values are multiplied by to be in SI.
        label: the column as messages name it.
    """

    index: int
    channel: Channel | None
    factor: float
    label: str


def parse_channel_map(options: Sequence[str]) -> dict[str, str]:
    """Read entries such as "Force=force_floor1 [N]" into {"Force": "force_floor1 [N]"}.

    Raises:
        RecordingError: an entry without "=", a unit that there is not, or a doubled column.
    """
    found: dict[str, str] = {}
    for option in options:
        foreign, equals, ours = (part.strip() for part in option.rpartition("="))
        if not equals or not foreign or not ours:
            raise RecordingError(
                f"--map {shown(option)} is not of the form 'Force=force_floor1 [N]'"
            )
        name, unit = split_name(ours)
        if name != TIME and unit is not None:
            channel_in(name, unit, f"--map {shown(option)}")
        if foreign in found:
            raise RecordingError(f"--map names the column {shown(foreign)} twice")
        found[foreign] = ours
    return found


def assign(
    table: Table, channel_map: Mapping[str, str] | None, rate_given: bool
) -> tuple[list[Assignment], tuple[str, ...]]:
    """Choose the columns to load, the time column among them if there is one.

    Without a map every column has to carry a unit. With one, only what it names is used, and a
    column "time" that has a unit.

    Args:
        table: what the file offers.
        channel_map: {column's name: "channel [unit]"}; a unit here overrides the file's.
        rate_given: the sampling rate is known, so that a time column may lack its unit.

    Returns:
        The assignments and notes on what was left out.

    Raises:
        RecordingError: doubled channels, missing or wrong units, a map that names what the file
            lacks.
    """
    if channel_map:
        chosen, notes = _mapped(table, channel_map, rate_given)
    else:
        chosen, notes = _all_columns(table, rate_given), ()
    _refuse_doubles(table, chosen)
    return [_assignment(table, *choice) for choice in chosen], notes


def _all_columns(table: Table, rate_given: bool) -> list[tuple[int, str, str | None]]:
    """Take every column under its own name."""
    time = _time_column(table, set())
    return [
        (index, TIME if index == time else column.name, column.unit)
        for index, column in enumerate(table.columns)
        if not (index == time and column.unit is None and rate_given)
    ]


def _time_column(table: Table, taken: set[int]) -> int | None:
    """Return the column of the time: by its name, or the first one if its unit is one of time."""
    free = [(i, c) for i, c in enumerate(table.columns) if i not in taken]
    named = [i for i, c in free if c.name.strip().casefold() == TIME]
    exact = [i for i in named if table.columns[i].name == TIME]
    first = [i for i, c in free if i == 0 and c.unit in TIME_UNITS]
    return next(iter([*exact, *named, *first]), None)


def _mapped(
    table: Table, channel_map: Mapping[str, str], rate_given: bool
) -> tuple[list[tuple[int, str, str | None]], tuple[str, ...]]:
    """Take what the map names."""
    chosen: list[tuple[int, str, str | None]] = []
    notes = []
    for foreign, ours in channel_map.items():
        index = _find(table, foreign)
        column = table.columns[index]
        name, unit = split_name(ours)
        if unit and column.unit and unit != column.unit:
            notes.append(f"column {column.label} is read in [{unit}], as the channel map says")
        chosen.append((index, name, unit or column.unit))
    used = {index for index, _, _ in chosen}
    if all(name != TIME for _, name, _ in chosen):
        time = _time_column(table, used)
        if time is not None and (table.columns[time].unit or not rate_given):
            chosen.append((time, TIME, table.columns[time].unit))
            used.add(time)
    left = [c.label for i, c in enumerate(table.columns) if i not in used and c.name]
    if left:
        notes.append(f"left out, as the channel map does not name them: {', '.join(left)}")
    return chosen, tuple(notes)


def _find(table: Table, foreign: str) -> int:
    """Return the index of the one column that is called so, with or without its unit."""
    wanted = split_name(foreign)
    matches = [
        index
        for index, column in enumerate(table.columns)
        if column.name == foreign or (column.name, column.unit) == wanted
    ]
    if not matches:
        raise RecordingError(
            f"{table.source}: no column {shown(foreign)}, which the channel map names; "
            f"the file has {table.listed()}"
        )
    if len(matches) > 1:
        raise RecordingError(
            f"{table.source}: column {shown(foreign)} appears {len(matches)} times "
            f"(columns {', '.join(str(index + 1) for index in matches)})"
        )
    return matches[0]


def _refuse_doubles(table: Table, chosen: list[tuple[int, str, str | None]]) -> None:
    first: dict[str, int] = {}
    for index, name, _ in chosen:
        if name in first:
            raise RecordingError(
                f"{table.source}: channel '{name}' appears twice "
                f"(columns {first[name] + 1} and {index + 1})"
            )
        first[name] = index


def _assignment(table: Table, index: int, name: str, unit: str | None) -> Assignment:
    """Look up the unit; refuse a column that holds no numbers."""
    column: Column = table.columns[index]
    where = f"{table.source}: column {column.label}"
    if column.problem:
        raise RecordingError(f"{where} {column.problem}")
    kind = TIME if name == TIME else implied_kind(name)
    if unit is None:
        plain = _plain(column.name)
        if kind is None:
            raise RecordingError(
                f"{where} has no unit, so nothing says what it measures; write its unit behind "
                f"its name in the file, or --map '{plain}={plain} [m/s^2]' (units: [N], [m/s^2], "
                "[g], [m/s], [mm], [rad], [rad/s], [N m], [m/m], [V])"
            )
        also = " or give the sampling rate (--rate HZ)" if kind == TIME else ""
        raise RecordingError(
            f"{where} has no unit; write {EXAMPLES[kind]} behind its name, "
            f"or --map '{plain}={name} {EXAMPLES[kind].split(',')[0]}'{also}"
        )
    if name == TIME:
        return Assignment(index, None, si_factor(unit, TIME, where), column.label)
    channel, factor = channel_in(name, unit, table.source)
    return Assignment(index, channel, factor, column.label)


def _plain(name: str) -> str:
    return shown(name)[1:-1]
