"""Recordings as MCAP, through ``mcap`` (read only): messages in JSON, a sample each.

A topic's number is a channel of the topic's name, several numbers are "topic.field" each. The unit
stands behind a field's name ("force [N]"), in the schema's property (``"unit": "N"``) or in the
channel's metadata (``unit``, or ``field.unit``). The time is the message's own ``timestamp``,
``stamp`` or ``header.stamp`` in seconds and nanoseconds, where it has one, else that of publishing.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError
from twin.formats.table import Column, Table, decoding, library
from twin.formats.time_axis import uniform
from twin.units import shown, split_name

Array = NDArray[np.float64]

STAMPS = ("timestamp", "stamp", "header.stamp")
NANOSECONDS = ("nanosec", "nsec", "nanos", "nsecs")

MISSING = 1.5
"""Steps in the median's units from which a message is missing between two."""


@dataclass
class _Topic:
    name: str
    encoding: str
    units: dict[str, str] = field(default_factory=dict)
    time_ns: list[int] = field(default_factory=list)
    values: dict[str, list[float]] = field(default_factory=dict)
    problems: dict[str, str] = field(default_factory=dict)


def read(path: Path) -> Table:
    """Read all messages; topics that are not in JSON are columns that say so.

    Raises:
        RecordingError: damaged, without messages, or none of them in JSON.
    """
    reader = library("mcap.reader", path)
    topics: dict[str, _Topic] = {}
    with decoding(path, "MCAP"), path.open("rb") as file:
        for schema, channel, message in reader.make_reader(file).iter_messages():
            topic = topics.get(channel.topic)
            if topic is None:
                units = _units(schema, channel.metadata)
                topic = _Topic(channel.topic.strip("/"), channel.message_encoding, units)
                topics[channel.topic] = topic
            if topic.encoding == "json":
                _take(topic, message)
    if not topics:
        raise RecordingError(f"{path}: holds no messages")
    if all(topic.encoding != "json" for topic in topics.values()):
        held = ", ".join(f"{shown(t.name)} in {t.encoding}" for t in topics.values())
        raise RecordingError(
            f"{path}: only messages in JSON are read, and there are {held}; write them in JSON, or "
            "export them as CSV"
        )
    first = min((t.time_ns[0] for t in topics.values() if t.time_ns), default=0)
    columns: list[Column] = []
    series: list[list[float]] = []
    for topic in topics.values():
        for column, values in _columns(topic, first):
            columns.append(column)
            series.append(values)

    def load(indices: Sequence[int]) -> list[Array]:
        return [np.array(series[index], float) for index in indices]

    return Table(str(path), tuple(columns), load, row="message")


def _units(schema: Any, metadata: Mapping[str, str]) -> dict[str, str]:
    """Return the units by field's name; "" is that of a topic's only one."""
    out = {key.removesuffix(".unit"): unit for key, unit in metadata.items() if "unit" in key}
    if "unit" in metadata:
        out = out | {"": metadata["unit"]}
    try:
        properties = json.loads(schema.data)["properties"] if schema else {}
    except (ValueError, KeyError, TypeError):
        return out
    described = {k: v["unit"] for k, v in properties.items() if isinstance(v, dict) and "unit" in v}
    return {k: str(v) for k, v in described.items()} | out


def _take(topic: _Topic, message: Any) -> None:
    content = json.loads(message.data)
    fields = dict(_flat(content)) if isinstance(content, dict) else {"": content}
    stamp, used = _stamp(fields)
    topic.time_ns.append(message.publish_time or message.log_time if stamp is None else stamp)
    number = len(topic.time_ns)
    for name, value in fields.items():
        if name in used:
            continue
        if isinstance(value, bool) or not isinstance(value, int | float):
            topic.problems.setdefault(name, f"holds {_kind(value)} in message {number}, no number")
            value = float("nan")
        values = topic.values.setdefault(name, [])
        if len(values) != number - 1:
            topic.problems.setdefault(name, f"is not in message {len(values) + 1}")
        values.append(float(value))


def _flat(content: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Return the values of nested objects by their names, joined by points."""
    for key, value in content.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value


def _stamp(fields: Mapping[str, Any]) -> tuple[int | None, set[str]]:
    """Return a message's own time [ns] and the fields that say it."""
    for name in STAMPS:
        seconds = fields.get(f"{name}.sec", fields.get(f"{name}.secs"))
        below = next((f"{name}.{n}" for n in NANOSECONDS if f"{name}.{n}" in fields), None)
        if seconds is not None and below is not None:
            used = {f"{name}.sec", f"{name}.secs", below}
            return int(seconds) * 10**9 + int(fields[below]), used
    return None, set()


def _kind(value: Any) -> str:
    words = {bool: "true or false", str: "text", list: "a list", type(None): "null"}
    return words.get(type(value), type(value).__name__)


def _columns(topic: _Topic, first_ns: int) -> Iterator[tuple[Column, list[float]]]:
    if topic.encoding != "json":
        yield Column(topic.name, problem=f"holds messages in {topic.encoding}, not in JSON"), []
        return
    axis, lost = _axis(topic, first_ns)
    for name, values in topic.values.items():
        bare, unit = split_name(name)
        single = len(topic.values) == 1
        problem = topic.problems.get(name) or lost
        if len(values) != len(topic.time_ns):
            problem = problem or f"is not in message {len(values) + 1}"
        unit = unit or topic.units.get(name) or topic.units.get(bare)
        unit = unit or (topic.units.get("") if single else None)
        title = topic.name if single else f"{topic.name}.{bare}"
        yield Column(title, unit, axis[0], axis[1], problem), values


def _axis(topic: _Topic, first_ns: int) -> tuple[tuple[float | None, float], str | None]:
    """Return a topic's rate [Hz] and first time [s], and what is wrong with its times.

    Times of logging wander: they then give no rate, and the user has to.
    """
    time = np.array([t - first_ns for t in topic.time_ns], float) * 1e-9
    start = float(time[0])
    if len(time) < 2:
        return (None, start), None
    try:
        found = uniform(time - start, lambda sample: f"message {sample + 1}")
        return (found.sampling_hz, start), None
    except RecordingError as error:
        steps = np.diff(time)
        if np.all(steps > 0) and steps.max() < MISSING * np.median(steps):
            return (None, start), None
        return (None, start), f"has no uniform times: {error}"
