"""Frequency responses that another program measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True)
class ResponseSet:
    """A matrix of frequency responses at common lines.

    Attributes:
        frequency_hz: lines [Hz], rising, (lines,).
        H: response of every output to every input, (lines, outputs, inputs).
        outputs: names of the responding degrees of freedom.
        inputs: names of the driven ones.
        source: where it came from.
        notes: what was done on reading.
    """

    frequency_hz: Array
    H: ComplexArray
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    source: str = "responses"
    notes: tuple[str, ...] = ()
