"""A parameter: what a fit may change, its unit, and what values it may take."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Scale = Literal["log", "linear"]


@dataclass(frozen=True)
class Parameter:
    """One number of a mechanism that a fit may change.

    Attributes:
        unit: SI unit; "1" for a pure number.
        meaning: what it is, in a few words.
        scale: "log" for one that keeps its sign (fitted through its logarithm), "linear" otherwise.
    """

    unit: str
    meaning: str
    scale: Scale = "linear"
