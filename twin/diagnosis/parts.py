"""In how many parts of a sample laws are stepped, and where a port yields within a part."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.problem import Problem
from twin.estimation.system import transition

Array = NDArray[np.float64]

STEPS, MOST_STEPS, FINEST = 4, 16, 64
"""Parts of a sample in which laws are stepped: at least, so that the instant of a jump is known to
a quarter of a sample, and at most, beyond which the third harmonic of the motion is near half the
sampling rate, where no output shows it. For a light damping of a mode that is as fast: of one at
half the sampling rate with a damping ratio of 0.25 %."""

HARMONIC, OUT_OF_STEP = 3, 2e-3
"""Up to which harmonic of the motion a law's force is stepped with so small a relative error: that
of the midpoint rule is (w h)^2 / 12."""

NARROW = 0.02
"""Share of a resonance's half-power width 2 zeta w by which the error of a force that is all its
stiffness may move it, (w h)^2 / 24 of w: its response changes by as much at most."""


def parts_of(problem: Problem, scales: Array, every_mode: bool) -> int:
    """Return the parts of a sample in which laws are stepped.

    Args:
        problem: whose recordings they are.
        scales: of force, displacement and rate at the laws' ports, (l, 3).
        every_mode: whether the laws lean on all modes, or are so stiff at times, as where friction
            holds, that they make another structure of it, whose modes move at their ports.
    """
    if not len(scales):
        return 1
    quickest = HARMONIC * float(np.max(scales[:, 2] / scales[:, 1]))
    wanted = _parts(quickest * problem.step_s, OUT_OF_STEP, MOST_STEPS)
    return max(wanted, _of_modes(problem)) if every_mode else wanted


def _parts(angle: Array | float, error: Array | float, most: int) -> int:
    """Return the parts of a sample, in which motions turn by angles, with these relative errors."""
    return int(np.clip(np.max(np.ceil(angle / np.sqrt(12 * error)), initial=STEPS), STEPS, most))


def _of_modes(problem: Problem) -> int:
    """Return in how many parts a law moves no resonance below half the sampling rate by much.

    No recording shows a resonance narrower than a period of its length.
    """
    frequencies, model = problem.frequencies, problem.model
    inside = (frequencies > 0) & (frequencies < problem.sampling_hz / 2)
    f, w = frequencies[inside], 2 * np.pi * frequencies[inside]
    damped = np.diag(model.R)[inside] / (2 * w * np.diag(model.M)[inside])
    longest = max(len(r.y) for r in problem.recordings) * problem.step_s
    narrowest = np.maximum(damped, 1 / (2 * f * longest))
    error = np.minimum(OUT_OF_STEP, 4 * NARROW * narrowest)
    return _parts(w * problem.step_s, error, FINEST)


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
