"""The force that a motion needs beyond what the twin's own equations and the inputs give."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.diagnosis.motion import Motion
from twin.diagnosis.problem import Problem
from twin.estimation.laws import memory_along
from twin.mechanisms.mechanism import Law

Array = NDArray[np.float64]


def needed(problem: Problem, z: Array, trial: int, motion: Motion) -> Array:
    """Return the forces on the coordinates that the motion needs besides the measured, (N, n).

    They are to be smoothed (``smooth``).

    Args:
        problem: the estimation problem.
        z: values of a hypothesis's unknowns, of which the base's come first, (p,).
        trial: index of the recording.
        motion: as it was estimated there.
    """
    model = problem.base(z[: len(problem.base_unknowns)])
    force = (
        motion.acceleration(problem.step_s) @ model.M + motion.v @ model.R.T + motion.q @ model.K
    )
    recording = problem.recordings[trial]
    known = recording.u @ model.B.T
    if problem.geometry is not None and recording.geometric is not None:
        known = known + recording.geometric.forces
    return np.asarray(force - known)


def smooth(problem: Problem, force: Array) -> Array:
    """Return forces, (N, n), without what is above four times the highest natural frequency."""
    inside = problem.frequencies[problem.frequencies < problem.sampling_hz / 2]
    corner = min(4 * float(np.max(inside, initial=1.0)), 0.4 * problem.sampling_hz)
    sos = signal.butter(4, corner, fs=problem.sampling_hz, output="sos")
    return np.asarray(signal.sosfiltfilt(sos, force, axis=0))


def nonlinear_share(law: Law, problem: Problem, moved: Sequence[Motion]) -> float:
    """Return the share of a law's RMS force along motions that no k d + c v is."""
    row = problem.model.port(law.place)
    force = np.concatenate([along_motion(law, problem, motion) for motion in moved])
    motion = np.vstack([np.column_stack([m.q @ row, m.v @ row]) for m in moved])
    motion = motion / np.maximum(np.max(np.abs(motion), axis=0), 1e-300)
    left = force - motion @ np.linalg.lstsq(motion, force, rcond=None)[0]
    return float(np.linalg.norm(left) / max(float(np.linalg.norm(force)), 1e-300))


def along_motion(law: Law, problem: Problem, motion: Motion) -> Array:
    """Return a law's force along a motion, (samples,)."""
    row = problem.model.port(law.place)
    drift, rate = motion.q @ row, motion.v @ row
    memory = memory_along(law.compiled, np.array(law.numbers), drift)
    time = np.asarray(np.arange(len(drift)) * problem.step_s, float)
    return np.broadcast_to(law.force(drift, rate, memory, time), drift.shape)
