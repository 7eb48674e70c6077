"""Reads a recorded ground motion: a CSV file with a time and an acceleration column."""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.errors import ExperimentError, available
from twin.laboratory.earthquake import Earthquake

Array = NDArray[np.float64]

UNITS = {
    "time": {"s": 1.0, "ms": 1e-3},
    "acceleration": {"m/s^2": 1.0, "m/s²": 1.0, "g": 9.80665, "cm/s^2": 0.01, "mm/s^2": 1e-3},
}
"""Units a column may have, with what one of them is in SI; a column without a unit is in SI."""

COLUMNS = {"time": ("time", "t"), "acceleration": ("acceleration", "acc", "acc_ground")}
"""Names a column may have."""

UNIFORM = 0.01
"""Times may miss their uniform grid by this share of a step: files are written with few digits."""


def read_ground_motion(path: Path, peak: float | None = None, delay_s: float = 0.0) -> Earthquake:
    """Read a ground motion from CSV: a header row, then numbers.

    The columns are ``time`` and ``acceleration``, each with or without a unit in brackets:
    ``time [s],acceleration [g]``. Other columns are ignored.

    Args:
        path: the file.
        peak: largest acceleration to scale the motion to [m/s^2], or None.
        delay_s: from the record's start to the first sample [s].

    Raises:
        ExperimentError: the file cannot be read, with its name, row and column.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise ExperimentError(f"{path}: cannot read this file ({error.strerror})") from None
    except UnicodeDecodeError:
        raise ExperimentError(f"{path}: this is no text file") from None
    try:
        reader = csv.reader(text.splitlines())
        rows = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    except csv.Error as error:
        raise ExperimentError(f"{path}: this is no CSV file ({error})") from None
    if not rows:
        raise ExperimentError(f"{path}: the file is empty")
    time = _column(path, rows, "time")
    acceleration = _column(path, rows, "acceleration")
    if len(time) < 2:
        raise ExperimentError(f"{path}: a ground motion needs at least two samples")
    step = (time[-1] - time[0]) / (len(time) - 1)
    if not step > 0:
        raise ExperimentError(f"{path}: the time does not increase")
    off = np.abs(time - time[0] - step * np.arange(len(time))) > UNIFORM * step
    if np.any(off):
        row = rows[1 + int(np.argmax(off))][0]
        raise ExperimentError(f"{path}: row {row}, column 'time': the time steps are not uniform")
    # the rate behind times that were rounded in print, where it is a plain number
    rate_hz = float(f"{1 / step:.6g}")
    return Earthquake(acceleration, rate_hz, peak, delay_s, name=path.name)


def _column(path: Path, rows: list[tuple[int, list[str]]], quantity: str) -> Array:
    """Return one quantity's column in SI units; ``rows`` are line numbers and cells."""
    header = [cell.strip() for cell in rows[0][1]]
    parts = [re.fullmatch(r"([^\[\]]+?)\s*(?:\[(.*)\])?", cell) for cell in header]
    found = [i for i, part in enumerate(parts) if part and part[1].lower() in COLUMNS[quantity]]
    if not found:
        raise ExperimentError(f"{path}: no column '{quantity}'; it has {available(header)}")
    index, name = found[0], header[found[0]]
    unit = name.partition("[")[2].rstrip("]").strip()
    if unit and unit not in UNITS[quantity]:
        raise ExperimentError(
            f"{path}: column '{name}' has an unknown unit; there are {available(UNITS[quantity])}"
        )
    values = []
    for number, row in rows[1:]:
        try:
            value = float(row[index])
        except (ValueError, IndexError):
            value = math.nan
        if not math.isfinite(value):
            raise ExperimentError(f"{path}: row {number}, column '{name}': no finite number there")
        values.append(value)
    return np.array(values) * UNITS[quantity].get(unit, 1.0)
