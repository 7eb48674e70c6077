"""Measured frequency responses as universal files, dataset 58 of function type 4."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from twin.errors import RecordingError
from twin.formats.contents import check_contents
from twin.formats.table import decoding, library
from twin.signals.responses import ResponseSet

FREQUENCY_RESPONSE = 4
"""Function type of a frequency response."""

SUFFIXES = (".uff", ".unv", ".58")

_DIRECTION = {0: "", 1: "x", 2: "y", 3: "z", 4: "rx", 5: "ry", 6: "rz"}


def holds_responses(path: str | Path) -> bool:
    """Whether a file holds frequency responses and no time histories."""
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES or not path.is_file():
        return False
    return any(kind == FREQUENCY_RESPONSE for kind in _kinds(path))


def read_responses(path: str | Path) -> ResponseSet:
    """Read the frequency responses of a universal file.

    Every set holds one response and one reference degree of freedom, "NODE.DIRECTION". With more
    references than responses (a roving hammer) the roles are exchanged, as reciprocity allows.

    Raises:
        RecordingError: no frequency responses, different lines, or a pair that is missing.
    """
    path = Path(path)
    check_contents(path, ", ".join(SUFFIXES))
    with decoding(path, "UFF"):
        sets = [s for s in _sets(path) if int(s["func_type"]) == FREQUENCY_RESPONSE]
    if not sets:
        raise RecordingError(f"{path}: no frequency responses (dataset 58 of function type 4)")
    found: dict[tuple[str, str], np.ndarray] = {}
    frequency = np.asarray(sets[0]["x"], float)
    for s in sets:
        pair = _point(s, "rsp"), _point(s, "ref")
        x = np.asarray(s["x"], float)
        if len(x) != len(frequency) or not np.allclose(x, frequency, rtol=1e-5):
            raise RecordingError(
                f"{path}: the response {pair[0]} to {pair[1]} has other frequency lines than "
                f"{_point(sets[0], 'rsp')} to {_point(sets[0], 'ref')}"
            )
        found[pair] = np.asarray(s["data"], complex)
    outputs = tuple(dict.fromkeys(pair[0] for pair in found))
    inputs = tuple(dict.fromkeys(pair[1] for pair in found))
    notes: tuple[str, ...] = ()
    if len(inputs) > len(outputs):
        found = {(pair[1], pair[0]): H for pair, H in found.items()}
        outputs, inputs = inputs, outputs
        notes = ("roving hammer: by reciprocity the references are taken as responses",)
    for o in outputs:
        for i in inputs:
            if (o, i) not in found:
                raise RecordingError(f"{path}: no response between {o} and {i}")
    H = np.array([[found[o, i] for i in inputs] for o in outputs]).transpose(2, 0, 1)
    if not np.all(np.isfinite(H)):
        bad = int(np.argwhere(~np.isfinite(H))[0, 0])
        raise RecordingError(f"{path}: a response at {frequency[bad]:g} Hz is not finite")
    return ResponseSet(frequency, H, outputs, inputs, path.name, notes)


def _sets(path: Path) -> list[dict[str, Any]]:
    file = library("pyuff", path).UFF(str(path))
    kinds = [int(kind) for kind in file.get_set_types()]
    return [file.read_sets(n) for n, kind in enumerate(kinds) if kind == 58]


def _kinds(path: Path) -> list[int]:
    check_contents(path, ", ".join(SUFFIXES))
    with decoding(path, "UFF"):
        return [int(s["func_type"]) for s in _sets(path)]


def _point(s: dict[str, Any], role: str) -> str:
    direction = int(s[f"{role}_dir"])
    name = _DIRECTION.get(abs(direction), str(abs(direction)))
    sign = "-" if direction < 0 else ""
    return f"{int(s[f'{role}_node'])}{'.' if name else ''}{sign}{name}"
