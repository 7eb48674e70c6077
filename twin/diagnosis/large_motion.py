"""What large motion adds to the linear equations, along the motion that the recordings show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import start_of
from twin.diagnosis.between import ENOUGH
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.motion import motion_of
from twin.diagnosis.problem import Problem
from twin.estimation.likelihood import passes
from twin.model import Twin
from twin.model.geometry import Geometric, Geometry, geometry_of

Array = NDArray[np.float64]


def with_large_motion(twin: Twin, problems: Sequence[Problem]) -> list[Problem]:
    """Return problems with what large motion adds, where the first one's recordings show it.

    The motion is the estimate of a predictor that trusts the nominal model little.

    Args:
        twin: the nominal one.
        problems: of the training recordings, and others of the same model.
    """
    geometry = geometry_of(twin, problems[0].model)
    if geometry is None:
        return list(problems)
    out: list[Problem] = []
    for problem in problems:
        every = _along(problem, geometry)
        if not out and not _seen(problem, geometry, every):
            return list(problems)
        pairs = zip(problem.recordings, every, strict=True)
        recordings = tuple(replace(recording, geometric=more) for recording, more in pairs)
        out.append(replace(problem, recordings=recordings, kinematics=geometry))
    return out


def _along(problem: Problem, geometry: Geometry) -> list[Geometric]:
    blank, n = Hypothesis(problem), len(problem.model.coordinates)
    found = []
    for run, recording in zip(passes(blank, start_of(blank)), problem.recordings, strict=True):
        motion = motion_of(run, n, problem.step_s)
        found.append(geometry.along(motion.q, motion.v, recording.u))
    return found


def _seen(problem: Problem, geometry: Geometry, every: Sequence[Geometric]) -> bool:
    """Say whether large motion changes the outputs, beside their noise, by what evidence shows."""
    nats = 0.0
    for levels, geometric in zip(problem.output_levels, every, strict=True):
        change = geometry.moved_by(geometric, problem.sampling_hz)
        nats += 0.5 * float(np.sum((change / levels) ** 2))
    return not nats <= ENOUGH
