"""Exact discretisation of a model whose inputs are held, or linear, between samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.estimation.system import transition

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Step:
    """z(t + h) = A z(t) + B_0 u(t) + B_1 u(t + h), u linear in between.

    For an input held at u(t) the influence is B_0 + B_1.
    """

    A: Array
    B_0: Array
    B_1: Array

    @property
    def held(self) -> Array:
        """Influence of an input held over the step."""
        return self.B_0 + self.B_1


def step(A: Array, B: Array, h: float) -> Step:
    """Return the transition over h seconds; zero is allowed."""
    n, m = B.shape
    if h == 0:
        return Step(np.eye(n), np.zeros((n, m)), np.zeros((n, m)))
    whole, held, ramp = transition(A, B, h, m)
    return Step(whole, held - ramp, ramp)
