"""Recordings as National Instruments TDMS, through npTDMS (read only)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError
from twin.formats.table import Column, Table, decoding, library, samples_of

Array = NDArray[np.float64]


def read(path: Path) -> Table:
    """List the channels; those that are wanted are loaded when they are asked for.

    A channel is named by its own name, or "group/channel" where two groups share it. Rate and
    start come from the waveform properties that LabVIEW writes.

    Raises:
        RecordingError: damaged, or without channels.
    """
    nptdms = library("nptdms", path)
    with decoding(path, "TDMS"):
        file = nptdms.TdmsFile.read_metadata(path)
        channels = [(g.name, c.name, c) for g in file.groups() for c in g.channels()]
        names = [name for _, name, _ in channels]
        columns = tuple(
            _column(name if names.count(name) == 1 else f"{group}/{name}", channel)
            for group, name, channel in channels
        )
    if not columns:
        raise RecordingError(f"{path}: holds no channels")

    def load(indices: Sequence[int]) -> list[Array]:
        with decoding(path, "TDMS"), nptdms.TdmsFile.open(path) as opened:
            return [
                samples_of(opened[group][name][:], f"{path}: column '{name}'")
                for group, name, _ in (channels[index] for index in indices)
            ]

    return Table(str(path), columns, load)


def _column(name: str, channel: Any) -> Column:
    properties = channel.properties
    unit = properties.get("unit_string") or properties.get("NI_UnitDescription") or None
    step = properties.get("wf_increment")
    rate = 1 / float(step) if step else None
    start = float(properties.get("wf_start_offset", 0.0)) if step else 0.0
    return Column(name, unit, rate, start)
