"""Frequency responses by pairs of points, gathered into a matrix."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError
from twin.signals.responses import ResponseSet

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
T = TypeVar("T")
Pair = tuple[str, str]
"""Responding point, driven point."""


@dataclass
class Measured:
    """What one file holds.

    Attributes:
        frequency_hz: lines [Hz], (lines,).
        H: response of each pair, (lines,).
        coherence: ordinary coherence of each pair, (lines,), where the file has it.
    """

    frequency_hz: Array
    H: dict[Pair, ComplexArray] = field(default_factory=dict)
    coherence: dict[Pair, Array] = field(default_factory=dict)


def gathered(files: Sequence[tuple[Path, Measured]]) -> ResponseSet:
    """Return one matrix of the responses of all files.

    With more driven than responding points (a roving hammer) the roles are exchanged, as
    reciprocity allows.

    Raises:
        RecordingError: different lines, a pair that is missing, measured twice or not finite.
    """
    first, frequency = files[0][0], files[0][1].frequency_hz
    if len(frequency) < 2 or not np.all(np.diff(frequency) > 0):
        raise RecordingError(f"{first}: the frequencies do not rise from line to line")
    H: dict[Pair, ComplexArray] = {}
    coherence: dict[Pair, Array] = {}
    for path, found in files:
        here = found.frequency_hz
        if len(here) != len(frequency) or not np.allclose(here, frequency, rtol=1e-5):
            raise RecordingError(f"{path}: other frequency lines than {first}")
        for pair in found.H:
            if pair in H:
                raise RecordingError(f"{path}: the response of {pair[0]} to {pair[1]} stands twice")
        H |= found.H
        coherence |= found.coherence
    outputs, inputs = (tuple(dict.fromkeys(pair[k] for pair in H)) for k in (0, 1))
    notes: tuple[str, ...] = ()
    if len(inputs) > len(outputs):
        H, coherence = _exchanged(H), _exchanged(coherence)
        outputs, inputs = inputs, outputs
        notes = ("roving hammer: by reciprocity the references are taken as responses",)
    for o in outputs:
        for i in inputs:
            if (o, i) not in H:
                raise RecordingError(f"{first}: no response between {o} and {i}")
    matrix = np.array([[H[o, i] for i in inputs] for o in outputs]).transpose(2, 0, 1)
    if not np.all(np.isfinite(matrix)):
        bad = int(np.argwhere(~np.isfinite(matrix))[0, 0])
        raise RecordingError(f"{first}: a response at {frequency[bad]:g} Hz is not finite")
    known = None
    if coherence and all((o, i) in coherence for o in outputs for i in inputs):
        known = np.array([[coherence[o, i] for i in inputs] for o in outputs]).transpose(2, 0, 1)
        if not np.all((known >= 0) & (known <= 1 + 1e-6)):
            raise RecordingError(f"{first}: a coherence lies outside 0 to 1")
    more = f" and {len(files) - 1} more" if len(files) > 1 else ""
    source = first.name + more
    return ResponseSet(frequency, matrix, outputs, inputs, source, notes, known)


def _exchanged(found: dict[Pair, T]) -> dict[Pair, T]:
    return {(pair[1], pair[0]): values for pair, values in found.items()}
