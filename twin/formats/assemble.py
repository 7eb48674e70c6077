"""From a file's table to a recording in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError
from twin.formats.channel_map import Assignment, assign
from twin.formats.table import Table
from twin.formats.time_axis import TimeAxis, uniform
from twin.recording import Recording

Array = NDArray[np.float64]

FEWEST = 2
"""Fewer samples have no sampling rate."""

AGREEMENT = 1e-4
"""How closely a rate that is given has to agree with the time in the file."""


def assemble(
    table: Table, channel_map: Mapping[str, str] | None, sampling_hz: float | None
) -> Recording:
    """Load the columns that are wanted and make a recording of them.

    Args:
        table: what the file offers.
        channel_map: {column's name: "channel [unit]"}, or None where the file has our names.
        sampling_hz: rate of a file without time [Hz]; where the file has one, they must agree.

    Raises:
        RecordingError: names the file, and column and row where they are to blame.
    """
    if sampling_hz is not None and not (np.isfinite(sampling_hz) and sampling_hz > 0):
        raise RecordingError(
            f"{table.source}: the sampling rate {sampling_hz} Hz is no positive number"
        )
    rate = sampling_hz or table.sampling_hz
    assignments, notes = assign(table, channel_map, rate is not None)
    columns = _load(table, assignments)
    axis = _axis(table, assignments, columns, rate)
    pairs = [(a.channel, x) for a, x in zip(assignments, columns, strict=True) if a.channel]
    if not pairs:
        raise RecordingError(f"{table.source}: no channel but the time; it has {table.listed()}")
    return Recording(
        axis.sampling_hz,
        tuple(channel for channel, _ in pairs),
        np.column_stack([samples for _, samples in pairs]),
        Path(table.source).name,
        axis.start_s,
        notes,
    )


def _load(table: Table, assignments: list[Assignment]) -> list[Array]:
    """Return the columns in SI units, all of one length and finite."""
    raw = table.load([a.index for a in assignments])
    columns = []
    for assignment, values in zip(assignments, raw, strict=True):
        if len(values) != len(raw[0]):
            raise RecordingError(
                f"{table.source}: column {assignment.label} has {len(values)} samples "
                f"and column {assignments[0].label} has {len(raw[0])}"
            )
        values = values * assignment.factor
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise RecordingError(
                f"{table.at(int(bad[0]))}, column {assignment.label}: {values[bad[0]]} is not "
                f"finite"
                + (f" (and {len(bad) - 1} more)" if len(bad) > 1 else "")
                + "; cut the file there into two recordings, or fill the gap"
            )
        columns.append(values)
    if not columns or len(columns[0]) < FEWEST:
        count = len(columns[0]) if columns else 0
        raise RecordingError(
            f"{table.source}: {count} sample{'s' * (count != 1)} in {table.listed()}; "
            f"a recording has at least {FEWEST}"
        )
    return columns


def _axis(
    table: Table, assignments: list[Assignment], columns: list[Array], rate: float | None
) -> TimeAxis:
    """Return the time axis: of the time column, of the format itself, or the rate given."""
    found = None
    for assignment, values in zip(assignments, columns, strict=True):
        if assignment.channel is None:
            found = uniform(values, table.at)
    found = found or _common_axis(table, assignments)
    if found is None:
        if rate is None:
            raise RecordingError(
                f"{table.source}: no column 'time [s]' among {table.listed()}; "
                f"give the sampling rate (--rate HZ) or map a column to time"
            )
        return TimeAxis(rate, 0.0, 0.0)
    if rate is None:
        return found
    if abs(rate / found.sampling_hz - 1) > max(AGREEMENT, 2 * found.uncertainty):
        raise RecordingError(
            f"{table.source}: the time in the file says {found.sampling_hz:.9g} Hz, "
            f"not {rate:.9g} Hz"
        )
    return TimeAxis(rate, found.start_s, 0.0)


def _common_axis(table: Table, assignments: list[Assignment]) -> TimeAxis | None:
    """Return the axis that the format keeps with each column; they have to agree."""
    columns = [table.columns[a.index] for a in assignments]
    first = columns[0]
    for column in columns:
        same_rate = column.sampling_hz == first.sampling_hz
        apart = abs(column.start_s - first.start_s) * (first.sampling_hz or 0)
        if not same_rate or apart > 0.01:
            raise RecordingError(
                f"{table.source}: {first.label} and {column.label} are not sampled together: "
                f"{_describe(first.sampling_hz, first.start_s)} and "
                f"{_describe(column.sampling_hz, column.start_s)}"
            )
    if first.sampling_hz is None:
        return None
    return TimeAxis(first.sampling_hz, first.start_s, 0.0)


def _describe(rate: float | None, start: float) -> str:
    return "no rate" if rate is None else f"{rate:.9g} Hz from {start:.9g} s"
