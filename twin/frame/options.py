"""Solver settings that every written model has, and a step that fits its fastest mode."""

from __future__ import annotations

import math

import numpy as np

from twin.frame.mjcf import Document, add
from twin.linearise import Linearisation

TIMESTEP = 0.001
ACCURATE_PHASE = 0.25
"""Largest angular frequency times step: RK4 then shifts the fastest mode by 3e-5,
(w h)^4 / 120 of its frequency; it is stable up to 2.8."""


def options(document: Document, gravity: float) -> None:
    """Write integrator, gravity and flags; the step is set when the modes are known.

    The dense Jacobian avoids a fault of MuJoCo 4.0.0's Newton solver with sparse ones.
    """
    document.section("compiler").set("angle", "radian")
    option = document.section("option")
    for name, value in {
        "integrator": "RK4",
        "jacobian": "dense",
        "tolerance": "1e-15",
        "gravity": f"0 0 {-gravity!r}",
    }.items():
        option.set(name, value)
    add(option, "flag", contact="disable")


def timestep_of(structure: Linearisation) -> str:
    """Return 1 ms, or with fast modes the step that divides it and keeps RK4 accurate [s]."""
    matrices = structure.generalised
    squares = np.linalg.eigvals(np.linalg.solve(matrices.M, matrices.K)).real
    fastest = math.sqrt(max(float(np.max(squares)), 0.0))
    return repr(TIMESTEP / max(1, math.ceil(fastest * TIMESTEP / ACCURATE_PHASE)))
