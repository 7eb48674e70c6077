"""In how many parts of a sample laws are stepped, and where a port yields within a part."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.problem import Problem
from twin.estimation.system import transition

Array = NDArray[np.float64]

STEPS, MOST_STEPS = 4, 16
"""Parts of a sample in which laws are stepped: at least, so that the instant of a jump is known to
a quarter of a sample, and at most, beyond which the third harmonic of the motion is near half the
sampling rate, where no output shows it."""

HARMONIC, OUT_OF_STEP = 3, 2e-3
"""Up to which harmonic of the motion a law's force is stepped with so small a relative error: that
of the midpoint rule is (w h)^2 / 12."""


def parts_of(problem: Problem, scales: Array, every_mode: bool) -> int:
    """Return the parts of a sample in which laws are stepped.

    Args:
        problem: whose recordings they are.
        scales: of force, displacement and rate at the laws' ports, (l, 3).
        every_mode: whether the laws are so stiff at times, as where friction holds, that they make
            another structure of it, whose modes move at their ports as the own ones may not.
    """
    if not len(scales):
        return 1
    quickest = HARMONIC * float(np.max(scales[:, 2] / scales[:, 1]))
    if every_mode:
        modes = problem.frequencies[problem.frequencies < problem.sampling_hz / 2]
        quickest = max(quickest, 2 * np.pi * float(np.max(modes, initial=0.0)))
    wanted = np.ceil(quickest * problem.step_s / np.sqrt(12 * OUT_OF_STEP))
    return int(np.clip(wanted, STEPS, MOST_STEPS))


def yielding(problem: Problem, places: Sequence[str], part_s: float) -> NDArray[np.bool_]:
    """Return where modes are too fast for a part of a sample, (ports,).

    A force that is constant over a part h moves a mode at w by d and its rate by v; damping aside,
    v h / (2 d) = (w h / 2) / tan(w h / 2) is less than 1 by the midpoint rule's error (w h)^2 / 12.
    Where that is too large the port yields to the force as a spring does: the rate with which a
    part ends says little of it, and is taken from the displacement.

    Args:
        problem: whose nominal structure it is.
        places: the ports.
        part_s: h [s].
    """
    model = problem.model
    rows = np.array([model.port(place) for place in places]).reshape(len(places), len(model.M))
    push = np.vstack([0 * rows.T, np.linalg.solve(model.M, rows.T)])
    _, moved, _ = transition(model.state_space().A, push, part_s, 0)
    n = len(model.M)
    d, v = np.einsum("ln,nl->l", rows, moved[:n]), np.einsum("ln,nl->l", rows, moved[n:])
    return np.asarray(v * part_s / (2 * d) < 1 - OUT_OF_STEP)
