"""The half of ``twin inspect`` that is about recordings."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

from twin.cli.common import console, write_json


def inspect_recording(
    path: Path,
    channel_map: Sequence[str] | None,
    rate: float | None,
    json: str | None,
    model: str | None = None,
) -> None:
    """Print what a recording holds and what may be wrong with it, and write it as JSON.

    Args:
        path: the recording.
        channel_map: what its columns are.
        rate: sampling rate of a file without time [Hz].
        json: where to write the JSON.
        model: whose channels the suggested ``--map`` names.

    Raises:
        TwinError: the file or the model cannot be read.
    """
    from twin.errors import RecordingError
    from twin.formats import open_table, parse_channel_map, read_recording
    from twin.formats.suggest import suggest_map
    from twin.signals.inspection import inspect

    offered = _channels(model)
    terminal = console(json)
    table = open_table(path)
    suggested = suggest_map([c for c in table.columns if c.name.casefold() != "time"], offered)
    strange = [c for c in table.columns if c.name not in offered] if offered else []
    try:
        found = inspect(read_recording(path, parse_channel_map(channel_map or []), rate))
    except RecordingError as error:
        unnamed = [c for c in table.columns if c.unit is None and c.name.casefold() != "time"]
        if channel_map or not (unnamed and suggested):
            raise
        terminal.print(f"[bold]{escape(str(path))}[/bold]: {escape(table.listed())}")
        terminal.print(escape(str(error)))
        _suggest(terminal, path, suggested, rate)
        write_json({"source": str(path), "error": str(error), "suggested_map": suggested}, json)
        return
    recording = found.recording
    terminal.print(
        f"[bold]{escape(str(path))}[/bold]: {recording.samples} samples at "
        f"{recording.sampling_hz:.9g} Hz ({recording.duration_s:.6g} s)"
    )
    shown = Table(box=SIMPLE_HEAD, show_edge=False)
    for header in ("channel", "role"):
        shown.add_column(header, overflow="fold")
    for header in ("RMS", "mean", "peak", "coherence"):
        shown.add_column(header, justify="right", no_wrap=True)
    for channel in found.channels:
        shown.add_row(
            escape(channel.title), channel.role,
            *(f"{value:.4g}" for value in (channel.rms, channel.mean, channel.peak)),
            "" if channel.coherence is None else f"{channel.coherence:.3f}",
        )  # fmt: skip
    terminal.print(shown)
    warnings = found.warnings()
    for line in warnings:
        terminal.print(f"fault: {escape(line)}")
    if not warnings:
        terminal.print("no faults seen")
    for note in recording.notes:
        terminal.print(f"note: {escape(note)}")
    if strange and suggested and not channel_map:
        _suggest(terminal, path, suggested, rate)
    write_json({**found.as_json(), "suggested_map": suggested}, json)


def _channels(model: str | None) -> Mapping[str, str]:
    if model is None:
        return {}
    from twin.model import Twin
    from twin.sensor_kinds import channel_kinds

    return channel_kinds(Twin.load(model).compile())


def _suggest(terminal: Any, path: Path, suggested: Mapping[str, str], rate: float | None) -> None:
    options = [f"--map {shlex.quote(f'{column}={title}')}" for column, title in suggested.items()]
    given = [] if rate is None else [f"--rate {rate:g}"]
    terminal.print("a guess at what the columns are, to check and to use with every command:")
    terminal.print(escape(" ".join([shlex.quote(str(path)), *given, *options])), soft_wrap=True)
