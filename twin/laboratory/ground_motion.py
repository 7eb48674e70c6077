"""Reads a recorded ground motion."""

from __future__ import annotations

from pathlib import Path

from twin.errors import ExperimentError
from twin.formats import FORMATS, read_recording
from twin.formats import csv as csv_format
from twin.formats.contents import check_contents
from twin.laboratory.earthquake import Earthquake

ACCELERATION = "acceleration"
"""A strong-motion file's own name for what a recording calls ``acc_ground``."""


def read_ground_motion(
    path: str | Path, peak: float | None = None, delay_s: float = 0.0
) -> Earthquake:
    """Read a ground motion: a recording with ``acc_ground``, or a strong-motion CSV file.

    The latter has the columns ``time`` and ``acceleration``, each with or without a unit behind
    it, such as ``time [s],acceleration [g]``; without one they are in SI units.

    Args:
        path: the file.
        peak: largest acceleration to scale the motion to [m/s^2], or None.
        delay_s: from the record's start to the first sample [s].

    Raises:
        TwinError: the file cannot be read, with its name, row and column, or has no ground
            acceleration.
    """
    path = Path(path)
    recording = read_recording(path, _channel_map(path))
    if "acc_ground" not in recording.names:
        raise ExperimentError(
            f"{path}: no column 'acceleration' or 'acc_ground'; it has {', '.join(recording.names)}"
        )
    acceleration = recording.column("acc_ground")
    return Earthquake(acceleration, recording.sampling_hz, peak, delay_s, name=path.name)


def _channel_map(path: Path) -> dict[str, str] | None:
    """Return what a strong-motion file's columns are, or None for a recording of ours."""
    if FORMATS.get(path.suffix.lower()) != "csv":
        return None
    check_contents(path, ", ".join(FORMATS))
    units = {column.name: column.unit for column in csv_format.read(path).columns}
    if ACCELERATION not in units:
        return None
    acceleration = f"acc_ground [{units[ACCELERATION] or 'm/s^2'}]"
    return {"time": f"time [{units.get('time') or 's'}]", ACCELERATION: acceleration}
