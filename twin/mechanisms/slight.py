"""Structural changes whose force along a known motion is known while they are slight."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from twin.mechanisms.mechanism import StructuralChange, Surroundings

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SlightChange(StructuralChange):
    """A change that hardly alters the motion while it is slight.

    Its force is then linear in its strength, and all values of what it is not linear in can be
    laid beside a recording at once.
    """

    @classmethod
    @abstractmethod
    def light(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return slight ones on a grid of what their force is not linear in."""

    @abstractmethod
    def reaction(self, rate: Array, step_s: float) -> Array:
        """Return the force [N] that it takes from a place moving at ``rate`` [m/s], (samples,)."""
