"""Measured frequency responses as universal files, dataset 58 of function types 4 and 6."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from twin.errors import RecordingError
from twin.formats.contents import check_contents
from twin.formats.response_pairs import Measured
from twin.formats.table import decoding, library

FREQUENCY_RESPONSE, COHERENCE = 4, 6
"""Function types of a frequency response and of a coherence."""

_DIRECTION = {0: "", 1: "x", 2: "y", 3: "z", 4: "rx", 5: "ry", 6: "rz"}


def holds(path: Path) -> bool:
    """Whether a file holds frequency responses and no time histories."""
    return any(kind == FREQUENCY_RESPONSE for kind in _kinds(path))


def read(path: Path) -> Measured:
    """Read the frequency responses and coherences of a universal file, by pairs of points.

    Raises:
        RecordingError: no frequency responses, or sets on different lines.
    """
    with decoding(path, "UFF"):
        sets = _sets(path)
    chosen = [s for s in sets if int(s["func_type"]) == FREQUENCY_RESPONSE]
    if not chosen:
        raise RecordingError(f"{path}: no frequency responses (dataset 58 of function type 4)")
    frequency = np.asarray(chosen[0]["x"], float)
    found = Measured(frequency)
    for s in chosen:
        pair = _point(s, "rsp"), _point(s, "ref")
        x = np.asarray(s["x"], float)
        if len(x) != len(frequency) or not np.allclose(x, frequency, rtol=1e-5):
            raise RecordingError(
                f"{path}: the response {pair[0]} to {pair[1]} has other frequency lines than "
                f"{_point(chosen[0], 'rsp')} to {_point(chosen[0], 'ref')}"
            )
        found.H[pair] = np.asarray(s["data"], complex)
    for s in sets:
        if int(s["func_type"]) == COHERENCE and len(s["data"]) == len(frequency):
            found.coherence[_point(s, "rsp"), _point(s, "ref")] = np.real(s["data"])
    return found


def _sets(path: Path) -> list[dict[str, Any]]:
    file = library("pyuff", path).UFF(str(path))
    kinds = [int(kind) for kind in file.get_set_types()]
    return [file.read_sets(n) for n, kind in enumerate(kinds) if kind == 58]


def _kinds(path: Path) -> list[int]:
    check_contents(path, ".uff, .unv, .58")
    with decoding(path, "UFF"):
        return [int(s["func_type"]) for s in _sets(path)]


def _point(s: dict[str, Any], role: str) -> str:
    direction = int(s[f"{role}_dir"])
    name = _DIRECTION.get(abs(direction), str(abs(direction)))
    sign = "-" if direction < 0 else ""
    return f"{int(s[f'{role}_node'])}{'.' if name else ''}{sign}{name}"
