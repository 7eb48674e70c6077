"""Measured frequency responses as text: a column of frequencies, then parts of every response."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError
from twin.formats import csv
from twin.formats.response_pairs import Measured, Pair
from twin.formats.table import Table
from twin.signals.frf import FrequencyResponse

Array = NDArray[np.float64]

PARTS = {
    **dict.fromkeys(("real", "re"), "real"),
    **dict.fromkeys(("imag", "imaginary", "im"), "imag"),
    **dict.fromkeys(("magnitude", "mag", "amplitude", "abs"), "magnitude"),
    **dict.fromkeys(("phase", "angle"), "phase"),
    **dict.fromkeys(("coherence", "coh"), "coherence"),
    **dict.fromkeys(("deviation", "std"), "deviation"),
}
"""Last word of a column's name and the part of a response that it is; a deviation is not read."""

_NAME = re.compile(r"^(.+?)\s*/\s*(.+?)[\s_:]+([A-Za-z]+)$")


def holds(path: Path) -> bool:
    """Whether the header begins with a frequency and names parts of responses."""
    try:
        table = csv.read(path)
    except RecordingError:
        return False
    first = table.columns[0].name.strip().lower() if table.columns else ""
    return first.startswith("freq") and any(_part(c.name) for c in table.columns[1:])


def read(path: Path) -> Measured:
    """Read frequencies, responses and coherences.

    Raises:
        RecordingError: a column that is no part of a response, or a response without its other
            part.
    """
    table = csv.read(path)
    parts: dict[Pair, dict[str, int]] = {}
    for index, column in enumerate(table.columns[1:], 1):
        named = _part(column.name)
        if named is None:
            raise RecordingError(
                f"{path}: column {column.label} is no part of a response: 'acc_2/force_1 real' "
                "and the like, with imag, magnitude, phase or coherence"
            )
        pair, part = named
        if part in parts.setdefault(pair, {}):
            raise RecordingError(f"{path}: {pair[0]}/{pair[1]} {part} stands twice")
        parts[pair][part] = index
    values = table.load(range(len(table.columns)))
    found = Measured(values[0] * _hertz(table, path))
    for pair, at in parts.items():
        if {"real", "imag"} <= set(at):
            found.H[pair] = values[at["real"]] + 1j * values[at["imag"]]
        elif {"magnitude", "phase"} <= set(at):
            turn = 1.0 if table.columns[at["phase"]].unit == "rad" else np.pi / 180
            found.H[pair] = values[at["magnitude"]] * np.exp(1j * turn * values[at["phase"]])
        else:
            raise RecordingError(
                f"{path}: {pair[0]}/{pair[1]} has {', '.join(at)} only: a response is real and "
                "imag, or magnitude and phase"
            )
        if "coherence" in at:
            found.coherence[pair] = values[at["coherence"]]
    return found


def write(
    found: FrequencyResponse, outputs: Sequence[str], inputs: Sequence[str], path: Path
) -> int:
    """Write the lines that the inputs excite; return how many.

    Beside real and imaginary part stands the standard deviation of the response's random error,
    and with one input its coherence, where they are known.

    Raises:
        RecordingError: no excited line, or a file that cannot be written.
    """
    excited = np.flatnonzero(found.excited() & (found.frequency_hz > 0))
    if not len(excited):
        raise RecordingError(f"{path}: the inputs excite no line")
    at = slice(excited[0], excited[-1] + 1)
    header, columns = ["frequency [Hz]"], [found.frequency_hz[at]]
    for o, output in enumerate(outputs):
        for i, driven in enumerate(inputs):
            H = found.H[at, o, i]
            parts = {"real": H.real, "imag": H.imag}
            if found.coherence is not None and len(inputs) == 1:
                parts["coherence"] = found.coherence[at, o]
            if found.variance is not None:
                parts["deviation"] = np.sqrt(found.variance[at, o, i])
            header += [f"{output}/{driven} {part}" for part in parts]
            columns += list(parts.values())
    rows = (",".join(f"{x:.12g}" for x in row) for row in np.column_stack(columns))
    try:
        path.write_text("\n".join([",".join(header), *rows]) + "\n", encoding="utf-8")
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written ({error.strerror})") from None
    return len(columns[0])


def _part(name: str) -> tuple[Pair, str] | None:
    match = _NAME.match(name.strip())
    part = PARTS.get(match[3].lower()) if match else None
    return ((match[1], match[2]), part) if match and part else None


def _hertz(table: Table, path: Path) -> float:
    unit = table.columns[0].unit
    if unit in (None, "Hz"):
        return 1.0
    if unit == "kHz":
        return 1e3
    if unit in ("rad/s", "1/s"):
        return 1 / (2 * np.pi)
    raise RecordingError(f"{path}: a frequency in {unit}; Hz, kHz and rad/s are known")
