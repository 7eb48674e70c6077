"""Recordings as the likelihood sees them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.aliased import aliased
from twin.diagnosis.measured import Load, Measured
from twin.diagnosis.straight import HoldError, hold_error, prefiltered
from twin.estimation.blows import Blows
from twin.estimation.model import Trial
from twin.estimation.trust import BESIDE_NOISE
from twin.model.linear import LinearModel

if TYPE_CHECKING:
    from twin.diagnosis.problem import Problem

Array = NDArray[np.float64]

EDGE = 16
"""Samples at the end of a recording that are left out: a channel that is late ends before its
recording does, by at most an eighth of a period of the band and as much for the filters."""


def trial_of(
    problem: Problem, recording: Measured, u: Array | None = None, y: Array | None = None
) -> Trial:
    """Return a recording as the likelihood sees it.

    Args:
        problem: what the inputs do between samples, and whether large motion is seen.
        recording: what was measured.
        u: other inputs than its own, (samples, r).
        y: other outputs, (samples, m).
    """
    u = recording.u if u is None else u
    between, blur, missed, blows = u, None, None, None
    if not np.all(problem.cornered):
        smooth = np.where(problem.cornered, 0.0, u)
        missed = problem.hold_errors[recording.load].of(smooth)
        blows = Blows(smooth, problem.low_pass) if problem.low_pass is not None else None
        between = np.where(problem.cornered, u, prefiltered(u))
        structure = problem.folding or problem.model
        blur = aliased(structure, smooth, problem.step_s, recording.input_noise)
        blur[blur < BESIDE_NOISE * recording.output_noise**2] = 0.0
    if problem.geometry is not None:
        forces = np.zeros((len(u), problem.pseudo_forces))
        if recording.geometric is not None:
            forces = recording.geometric.forces
        between = np.hstack([between, prefiltered(forces)])
        u = np.hstack([u, forces])
    limited = None
    if not np.all(problem.cornered):
        limited = np.concatenate([~problem.cornered, np.ones(problem.pseudo_forces, bool)])
    seen = blur if blur is not None and np.any(blur) else None
    known = _known(problem, recording, recording.y if y is None else y, missed)
    return Trial(u, between, known, problem.step_s, limited, seen, missed, blows)


def reread(problem: Problem, index: int, y: Array) -> Trial:
    """Return a recording as the likelihood sees it, its inputs as they are.

    Args:
        problem: whose recording it is.
        index: of the recording.
        y: other outputs than its own, (samples, m).
    """
    recording, trial = problem.recordings[index], problem.trials[index]
    return replace(trial, y=_known(problem, recording, y, trial.missed))


def _known(problem: Problem, recording: Measured, y: Array, missed: Array | None) -> Array:
    """Return outputs less what lines miss of the inputs, and what large motion reads, (samples, m).

    Args:
        problem: whose recording it is.
        recording: what was measured.
        y: the outputs, (samples, m).
        missed: what lines miss, (samples, m), if they miss anything.
    """
    known = np.array(y)
    known[len(known) - EDGE :] = np.nan
    if missed is not None:
        known -= missed
    if problem.geometry is not None and recording.geometric is not None:
        known -= recording.geometric.readings
    return known


def hold_errors(problem: Problem, structure: LinearModel) -> dict[Load, HoldError]:
    """Return what lines miss of a structure with each set of masses bolted on."""
    out = dict[Load, HoldError]()
    for load in {recording.load for recording in problem.recordings}:
        loaded = structure
        for place, mass in load:
            loaded = loaded.loaded(place, mass)
        out[load] = hold_error(loaded, problem.step_s)
    return out
