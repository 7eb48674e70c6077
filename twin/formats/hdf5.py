"""Recordings as HDF5, through h5py: one dataset a channel, its unit in the attribute ``unit``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from twin.formats.named_arrays import RATE, Entry, arrays_of, scalar, table_of, variables_of
from twin.formats.table import Table, decoding, library
from twin.recording import Recording


def read(path: Path) -> Table:
    """List the datasets of all groups; those that are wanted are loaded when asked for.

    A dataset in a group is named by its path ("run1/force"), or by its attribute ``name``. Units
    stand in the attribute ``unit`` or ``units``; the root's attribute ``sampling_hz`` is the rate
    of a file without time.

    Raises:
        RecordingError: damaged, or without datasets.
    """
    h5py = library("h5py", path)
    entries: list[Entry] = []

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            own = _text(item, "name") or name
            unit = _text(item, "unit") or _text(item, "units")
            entries.append(Entry(own, item.shape or (), unit, _problem(item), name))

    def load(name: str) -> Any:
        with decoding(path, "HDF5"), h5py.File(path, "r") as file:
            return file[name][()]

    with decoding(path, "HDF5"), h5py.File(path, "r") as file:
        file.visititems(visit)
        order = list(file)  # as created, where the file remembers that; the visit is by name
        entries.sort(key=lambda entry: order.index(entry.variable.split("/")[0]))
        declared = file.attrs.get(RATE)
    rate = None if declared is None else scalar(declared, f"{path}: attribute '{RATE}'")
    return table_of(path, entries, load, rate)


def write(recording: Recording, path: Path) -> None:
    """Write time and channels as datasets with their units."""
    h5py = library("h5py", path)
    channels = dict(zip(variables_of(recording).values(), recording.channels, strict=True))
    with h5py.File(path, "w", track_order=True) as file:
        for variable, values in arrays_of(recording).items():
            if variable == RATE:
                file.attrs[RATE] = recording.sampling_hz
                continue
            dataset = file.create_dataset(variable, data=np.ascontiguousarray(values))
            channel = channels.get(variable)
            dataset.attrs["unit"] = channel.unit if channel else "s"
            if channel and channel.name != variable:
                dataset.attrs["name"] = channel.name


def _text(dataset: Any, key: str) -> str | None:
    value = dataset.attrs.get(key)
    if isinstance(value, bytes):
        return value.decode("utf-8", errors="replace")
    return value if isinstance(value, str) else None


def _problem(dataset: Any) -> str | None:
    return None if dataset.dtype.kind in "iubf" else "does not hold real numbers"
