"""Scales of force, displacement and rate at every port, from an estimate of the motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TINY = 1e-15

ROUNDING = 1e-9
"""Share of a quantity below which what is left of it, once others are taken off, is rounding."""


@dataclass(frozen=True)
class Scales:
    """RMS values of the motion at ports.

    Attributes:
        by_port: name -> (elastic force [N], displacement [m], rate [m/s]), RMS over all recordings.
    """

    by_port: Mapping[str, tuple[float, float, float]]

    def at(self, port: str) -> tuple[float, float, float]:
        """Return force, displacement and rate at a port; never zero, so that they can divide."""
        force, drift, rate = self.by_port[port]
        return max(force, TINY), max(drift, TINY), max(rate, TINY)
