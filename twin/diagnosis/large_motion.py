"""What large motion adds to the linear equations, along the motion that the recordings show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import start_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.motion import motion_of
from twin.diagnosis.problem import Problem
from twin.estimation.likelihood import passes
from twin.model import Twin
from twin.model.geometry import Geometric, Geometry, geometry_of
from twin.model.self_check import NOTED

Array = NDArray[np.float64]


def with_large_motion(twin: Twin, problems: Sequence[Problem]) -> list[Problem]:
    """Return problems with what large motion adds, where the first one's recordings show it.

    The motion is the estimate of a predictor that trusts the nominal model little.

    Args:
        twin: the nominal one.
        problems: of the training recordings, and others of the same model.
    """
    geometry = geometry_of(twin, problems[0].model)
    if geometry is None or not any(_seen(problems[0], geometry, _along(problems[0], geometry))):
        return list(problems)
    out = []
    for problem in problems:
        recordings = tuple(
            replace(recording, geometric=geometric)
            for recording, geometric in zip(
                problem.recordings, _along(problem, geometry), strict=True
            )
        )
        out.append(replace(problem, recordings=recordings, geometry=geometry))
    return out


def _along(problem: Problem, geometry: Geometry) -> list[Geometric]:
    blank, n = Hypothesis(problem), len(problem.model.coordinates)
    found = []
    for run, recording in zip(passes(blank, start_of(blank)), problem.recordings, strict=True):
        motion = motion_of(run, n, problem.step_s)
        found.append(geometry.along(motion.q, motion.v, recording.u))
    return found


def _seen(problem: Problem, geometry: Geometry, every: Sequence[Geometric]) -> list[bool]:
    """Say of each recording whether large motion changes an output by a share of its noise."""
    seen = []
    for levels, geometric in zip(problem.output_levels, every, strict=True):
        change = geometry.moved_by(geometric, problem.sampling_hz)
        size = np.sqrt(np.mean(change**2, axis=0))
        seen.append(bool(np.any(~np.isfinite(size) | (size > NOTED * levels))))
    return seen
