"""Recordings as files: one reader a format, chosen by the file's suffix."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

from twin.errors import RecordingError
from twin.files import write_whole
from twin.formats.assemble import assemble
from twin.formats.channel_map import parse_channel_map
from twin.formats.contents import check_contents
from twin.formats.table import Table, decoding
from twin.recording import Recording
from twin.recording_checks import clipping_warnings

FORMATS = {
    ".csv": "csv",
    ".tsv": "csv",
    ".txt": "csv",
    ".asc": "csv",
    ".dat": "csv",
    ".gz": "csv",
    ".xlsx": "xlsx",
    ".uff": "uff",
    ".unv": "uff",
    ".58": "uff",
    ".mat": "mat",
    ".tdms": "tdms",
    ".mcap": "mcap",
    ".h5": "hdf5",
    ".hdf5": "hdf5",
    ".npz": "numpy_arrays",
    ".npy": "numpy_arrays",
}
"""Suffix of a file and the module of this package that reads it."""

WRITTEN = (".csv", ".uff", ".unv", ".mat", ".h5", ".hdf5", ".npz")
"""Suffixes that can be written."""


def read_recording(
    path: str | Path,
    channel_map: Mapping[str, str] | None = None,
    sampling_hz: float | None = None,
) -> Recording:
    """Read a recording and convert it to SI units.

    Args:
        path: the file; its suffix says the format.
        channel_map: {column of the file: "channel [unit]"}, such as
            {"Force": "force_floor1 [N]"}; columns that it does not name are left out, and said
            so in the recording's notes. "time [s]" may be a target too.
        sampling_hz: sampling rate of a file without time [Hz].

    Raises:
        TwinError: one line that names the file and, where they are to blame, column and row.
    """
    path = Path(path)
    table = open_table(path)
    with decoding(path, path.suffix):
        recording = assemble(table, channel_map, sampling_hz)
    return replace(recording, notes=recording.notes + clipping_warnings(recording))


def open_table(path: str | Path) -> Table:
    """Return what a file offers, its samples not yet loaded.

    Raises:
        TwinError: one line that names the file.
    """
    path = Path(path)
    check_contents(path, ", ".join(FORMATS))
    module = _module(path, tuple(FORMATS), "read")
    with decoding(path, path.suffix):
        table: Table = module.read(path)
    return table


def write_recording(recording: Recording, path: str | Path) -> Path:
    """Write a recording in SI units, whole or not at all, and return the path.

    Raises:
        TwinError: a suffix that cannot be written, a missing library, or a failing disk.
    """
    path = Path(path)
    module = _module(path, WRITTEN, "written")
    return write_whole(path, lambda part: module.write(recording, part))


def _module(path: Path, suffixes: tuple[str, ...], done: str) -> Any:
    suffix = path.suffix.lower()
    inner = Path(path.stem).suffix.lower()
    if suffix == ".gz" and FORMATS.get(inner) != "csv":
        raise RecordingError(f"{path}: only text is read from a .gz archive; unpack it first")
    if suffix not in suffixes:
        raise RecordingError(
            f"{path}: {f'{suffix} files' if suffix else 'files without a suffix'} cannot be "
            f"{done}; {', '.join(suffixes)} can"
        )
    return import_module(f"twin.formats.{FORMATS[suffix]}")


__all__ = [
    "FORMATS",
    "WRITTEN",
    "open_table",
    "parse_channel_map",
    "read_recording",
    "write_recording",
]
