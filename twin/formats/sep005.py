"""Recordings as SEP 005 time series, which packages of the sdypy family exchange.

A series is a dictionary with ``data``, ``name``, ``unit_str``, and ``fs`` [Hz] or ``time`` [s];
a recording is a list of them. Source: SDyPy Enhancement Proposal 005, "Time series".
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError
from twin.formats.assemble import assemble
from twin.formats.table import Column, Table, samples_of
from twin.formats.time_axis import uniform
from twin.recording import Recording
from twin.units import shown

Array = NDArray[np.float64]

QUANTITY = {"force": "f", "acc": "a", "vel": "v", "disp": "d", "strain": "e"}
"""The proposal's letter for each kind of channel that has one."""


def to_sep005(recording: Recording) -> list[dict[str, Any]]:
    """Return a recording as SEP 005 time series, in SI units.

    Examples:
        >>> from twin.recording import Recording
        >>> series = to_sep005(Recording.build(8.0, {"A3 [g]": [0.0, 1.0]}, "tap"))
        >>> series[0]["name"], series[0]["unit_str"], series[0]["fs"]
        ('A3', 'm/s^2', 8.0)
    """
    series = []
    for channel in recording.channels:
        one: dict[str, Any] = {
            "data": np.array(recording.column(channel.name)),
            "name": channel.name,
            "unit_str": channel.unit,
            "fs": float(recording.sampling_hz),
            "group": recording.source,
        }
        if channel.kind in QUANTITY:
            one["quantity"] = QUANTITY[channel.kind]
        if recording.start_s:
            one["time"] = recording.time.tolist()
        series.append(one)
    return series


def from_sep005(
    series: Sequence[Mapping[str, Any]],
    channel_map: Mapping[str, str] | None = None,
    source: str = "SEP 005 time series",
) -> Recording:
    """Return SEP 005 time series as a recording in SI units.

    Args:
        series: one dictionary a channel.
        channel_map: {name: "channel [unit]"} for series that do not say it themselves.
        source: what messages call them.

    Raises:
        RecordingError: a series that lacks something, is not sampled with the others, or has an
            unknown unit; one line that names it.
    """
    columns, data = [], []
    for number, one in enumerate(series):
        name = str(one.get("name", "")).strip()
        where = f"{source}: series {shown(name) if name else number + 1}"
        missing = [key for key in ("data", "name", "unit_str") if key not in one]
        if missing or (one.get("fs") is None and one.get("time") is None):
            raise RecordingError(
                f"{where} has no '{missing[0] if missing else 'fs'}'; SEP 005 asks for data, name, "
                "unit_str, and fs or time"
            )
        rate, start = _axis(one, where)
        columns.append(Column(name, str(one["unit_str"]).strip() or None, rate, start))
        data.append(samples_of(one["data"], where))
    if not columns:
        raise RecordingError(f"{source}: there is no time series")
    table = Table(source, tuple(columns), lambda wanted: [data[index] for index in wanted])
    return assemble(table, channel_map, None)


def _axis(one: Mapping[str, Any], where: str) -> tuple[float, float]:
    """Return the rate [Hz] and the first time [s] of a series."""
    time, rate = one.get("time"), one.get("fs")
    if time is None:
        value = samples_of([rate], where)[0]
        if not (np.isfinite(value) and value > 0):
            raise RecordingError(f"{where}: the sampling rate {rate} Hz is no positive number")
        return float(value), 0.0
    instants = samples_of(time, where)
    if len(instants) != np.size(one["data"]) or len(instants) < 2:
        raise RecordingError(
            f"{where} has {len(instants)} times for {np.size(one['data'])} samples"
        )
    axis = uniform(instants, lambda sample: f"{where}: sample {sample + 1}")
    return (axis.sampling_hz if rate is None else float(rate)), axis.start_s
