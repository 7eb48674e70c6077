"""What large motion adds to the linear equations, along the motion that the recordings show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import by_name, carried, start_of, widened
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.motion import corrected
from twin.diagnosis.problem import Problem
from twin.estimation.fit import fit
from twin.estimation.law_averages import LawAverages
from twin.estimation.likelihood import passes
from twin.estimation.passing import Run
from twin.model import Twin
from twin.model.geometry import Geometric, Geometry, geometry_of
from twin.model.linear import LinearModel

Array = NDArray[np.float64]

ENOUGH = 3.0
"""Evidence [nat] for a structure that does not move as its model does when it moves far: odds of
1 to 20; and for inputs that are not band-limited, as those of analysers are."""


def with_large_motion(
    twin: Twin, problems: Sequence[Problem]
) -> tuple[list[Problem], Mapping[str, float]]:
    """Return problems with what large motion adds, where the first one's recordings show it.

    Whether they do, a predictor says that trusts the nominal model little; along which motion, the
    twin calibrated without it. What explains more moves more nearly so (``along_its_motion``).

    Returns with them the values by name of the first one so calibrated, from which another
    calibration may begin; none where nothing is seen.

    Args:
        twin: the nominal one.
        problems: of the training recordings, and others of the same model.
    """
    geometry = geometry_of(twin, problems[0].model)
    if geometry is None:
        return list(problems), {}
    blank = Hypothesis(problems[0])
    if not _seen(problems[0], geometry, _along(blank, geometry, start_of(blank))):
        return list(problems), {}
    out, known, first = [], dict[str, float](), dict[str, float]()
    for problem in problems:
        blank = Hypothesis(problem)
        z = fit(blank, widened(blank, carried(blank, known))).z
        known |= by_name(blank, z)
        first = first or dict(known)
        out.append(_with(problem, geometry, _along(blank, geometry, z)))
    return out, first


def along_its_motion(
    hypothesis: Hypothesis, z: Array, averages: Sequence[LawAverages] | None = None
) -> Problem:  # fmt: skip
    """Return the problem of a hypothesis with what large motion adds along the motion it says.

    Args:
        hypothesis: whose problem has a geometry.
        z: values of its unknowns, (p,).
        averages: what its laws do on the average of each recording, where that is known.
    """
    problem = hypothesis.problem
    assert problem.kinematics is not None
    return _with(problem, problem.kinematics, _along(hypothesis, problem.kinematics, z, averages))


def _with(problem: Problem, geometry: Geometry, every: Sequence[Geometric]) -> Problem:
    pairs = zip(problem.recordings, every, strict=True)
    recordings = tuple(replace(recording, geometric=more) for recording, more in pairs)
    return replace(problem, recordings=recordings, kinematics=geometry)


def _along(
    hypothesis: Hypothesis, geometry: Geometry, z: Array,
    averages: Sequence[LawAverages] | None = None,
) -> list[Geometric]:  # fmt: skip
    problem = hypothesis.problem
    pairs = zip(passes(hypothesis, z, averages), hypothesis.trials, strict=True)
    return [along_pass(geometry, run, corrected(run), trial.u, problem.model)
            for run, trial in pairs]  # fmt: skip


def along_pass(
    geometry: Geometry, run: Run, x: Array, u: Array, model: LinearModel
) -> Geometric:  # fmt: skip
    """Return what large motion adds along a pass over a recording.

    What the pass's own equations accelerate by beyond the nominal ones, but for pseudo-forces, are
    the forces of laws, changes and disturbances.

    Args:
        geometry: of the nominal model.
        run: the pass.
        x: its states, (samples, states).
        u: inputs, and pseudo-forces behind them, (samples, inputs).
        model: the nominal equations.
    """
    system, n, r = run.sampled.system, len(model.coordinates), len(model.inputs)
    q, v = (part[:, :n] for part in run.moved(x))
    _, a = run.moved(x @ system.A.T + u @ system.B.T + run.f @ system.E.T)
    inputs, pseudo = u[:, :r], u[:, r : r + n]
    pushed = a[:, :n] @ model.M.T + v @ model.R.T + q @ model.K.T - inputs @ model.B.T
    if pseudo.shape[1]:
        pushed -= pseudo
    return geometry.along(q, v, inputs, pushed)


def _seen(problem: Problem, geometry: Geometry, every: Sequence[Geometric]) -> bool:
    """Say whether large motion changes the outputs, beside their noise, by what evidence shows."""
    nats = 0.0
    for levels, geometric in zip(problem.output_levels, every, strict=True):
        change = geometry.moved_by(geometric, problem.sampling_hz)
        nats += 0.5 * float(np.sum((change / levels) ** 2))
    return not nats <= ENOUGH
