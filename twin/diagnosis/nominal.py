"""The nominal twin before any diagnosis: what it holds beyond linear equations, and MuJoCo's check.

What a user's own model already holds is part of every hypothesis, with the model's values; where
those are off, the search finds the difference, and the exported twin holds the sum.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.arrays import rms_of, strongest
from twin.diagnosis.measured import Measured
from twin.diagnosis.portion import PART
from twin.diagnosis.problem import Problem
from twin.diagnosis.scales import Scales
from twin.diagnosis.sliders import together
from twin.errors import ModelError
from twin.mechanisms.edits import FRICTION_SOLIMP, FRICTION_SOLREF, FRICTION_STEP
from twin.mechanisms.held import gathered, held
from twin.mechanisms.mechanism import Law
from twin.mechanisms.rollout import rollout
from twin.model import Twin
from twin.model.amplitudes import Effect, effects
from twin.model.contents import nonlinear_elements
from twin.model.free_run import free_run
from twin.model.geometry import Geometry, geometry_of
from twin.model.self_check import NOTED, SelfCheck, self_check

Array = NDArray[np.float64]

LEAST = 1e-4
"""Share of an output's RMS below which no element's effect is worth having: rounding and steps."""

IDEAL = 1e-3
"""Share of the rate at its port within which dry friction in the model changes its sign: less is
lost than steps lose."""

FINER = 8
"""Samples to one that is recorded where laws have corners: the filter of the comparison then sees
what lies beyond the recorded band, up to four times the sampling rate."""

ANOTHER = 0.01
"""Difference between MuJoCo's motion and the equations', as a share of its RMS, that the equations
promise not to exceed; what exceeds it and the noise is another model, what is less a note."""


def with_known(twin: Twin, problem: Problem) -> tuple[Problem, tuple[str, ...]]:
    """Return the problem with what the model holds beyond linear equations, and notes about it.

    Raises:
        ModelError: an element that matters and that the vocabulary does not have.
    """
    everything = nonlinear_elements(twin.compile(), weights=problem.geometry is None)
    elements = gathered(everything, problem.model)
    if not elements:
        return problem, ()
    largest: dict[int, Effect] = {}
    for recording in problem.recordings:
        for effect in effects(problem.model, elements, recording.u, problem.sampling_hz):
            key = elements.index(effect.element)
            if key not in largest or effect.share > largest[key].share:
                largest[key] = effect
    found = held(list(largest.values()), max(NOTED * _noise(problem), LEAST), twin.source)
    scales, ideal = {}, []
    for mechanism in together(found.mechanisms, problem.model):
        if isinstance(mechanism, Law):
            scales[mechanism.place] = _scale(problem, mechanism)
            if mechanism.resolved_by:
                rate = scales[mechanism.place][2]
                mechanism = mechanism.with_values({mechanism.resolved_by: IDEAL * rate})
        ideal.append(mechanism)
    known = replace(problem, known=tuple(ideal), known_scales=Scales(scales))
    return known, found.notes


def checked(twin: Twin, problem: Problem, flat: bool = False) -> tuple[str, ...]:
    """Lay MuJoCo's motion beside the equations' in the loudest recording; return notes.

    Args:
        twin: the nominal one.
        problem: its equations and the recordings.
        flat: whether the equations do without what large motion adds: that is but a note.

    Raises:
        ModelError: they are another model; the message names the element, joint or mode.
    """
    model, rate = problem.model, problem.sampling_hz
    loudest = max(problem.recordings, key=lambda r: _size(r.y))
    u = loudest.u[strongest(loudest.y, PART)]
    laws = [m for m in problem.known if isinstance(m, Law)]
    cornered = any(law.abrupt or law.memory for law in laws)
    finer = FINER if cornered else 1
    times = np.arange(finer * (len(u) - 1) + 1) / finer
    fine = np.column_stack([np.interp(times, np.arange(len(u)), values) for values in u.T])
    inputs = dict(zip(model.inputs, fine.T, strict=True))
    size = {n: float(s) for n, s in zip(model.outputs, _levels(loudest), strict=True)}

    def beside(geometry: Geometry | None) -> SelfCheck:
        predicted = None
        if problem.known or geometry:
            predicted = _predicted(problem, geometry, fine, finer * rate)
        return self_check(twin, inputs, model.outputs, finer * rate, noise=size,
                          predicted=predicted, decimation=finer)  # fmt: skip

    check = beside(problem.geometry)
    left_out = geometry_of(twin, model) if flat and _another(check) else None
    if _another(check) and (left_out is None or _another(beside(left_out))):
        raise ModelError(f"{twin.source}: {check}{_creeping(twin)}")
    if check.of_noise[check.worst] > NOTED:
        return (f"{loudest.name}: {check}",)
    return ()


def _another(check: SelfCheck) -> bool:
    return check.differences[check.worst] > ANOTHER and not check.passed


def _creeping(twin: Twin) -> str:
    """Say how dry friction that MuJoCo lets creep becomes dry; nothing where it is."""
    model = twin.compile()
    rubbing = np.vstack([
        model.dof_solref[model.dof_frictionloss > 0],
        model.tendon_solref_fri[model.tendon_frictionloss > 0],
    ])  # fmt: skip
    if np.all(rubbing[:, 1] <= FRICTION_SOLREF[1]):
        return ""
    (stiffness, damping), hard = FRICTION_SOLREF, FRICTION_SOLIMP[0]
    return (
        f"; with these settings MuJoCo lets dry friction creep: beside frictionloss, write "
        f'solreffriction="{stiffness:g} {damping:g}" solimpfriction="{hard:g} {hard:g}", and at '
        f'most timestep="{FRICTION_STEP:g}"'
    )


def _predicted(
    problem: Problem, geometry: Geometry | None, u: Array, rate: float
) -> dict[str, Array]:  # fmt: skip
    """Return the equations' motion from rest: linear ones, laws, and what large motion adds."""
    model = problem.model
    moved = rollout(model, problem.known, dict(zip(model.inputs, u.T, strict=True)), rate)
    if geometry is None:
        return moved
    more = geometry.simulated(u, rate)
    return {name: moved[name] + more[:, i] for i, name in enumerate(model.outputs)}


def _levels(recording: Measured) -> Array:
    """Return the noise of each output; where none was seen, a hundredth of the output."""
    levels = recording.output_noise
    return np.asarray(np.where(levels > 0, levels, 0.01 * rms_of(recording.y)))


def _noise(problem: Problem) -> float:
    """Return the least noise of any output as a share of its RMS."""
    shares = [_levels(r) / np.maximum(rms_of(r.y), 1e-300) for r in problem.recordings]
    return float(np.min(shares))


def _size(y: Array) -> float:
    return float(np.sqrt(np.nanmean(y**2)))


def _scale(problem: Problem, law: Law) -> tuple[float, float, float]:
    """Return RMS force, displacement and rate of a law in the linear motion."""
    row = problem.model.port(law.place)
    seen = problem.model.seeing(np.vstack([row, 0 * row]), np.vstack([0 * row, row]))
    runs = [free_run(seen, r.u, problem.sampling_hz) for r in problem.recordings]
    times = [np.arange(len(run)) * problem.step_s for run in runs]
    drift, rate = np.vstack(runs).T
    force = law.force(drift, rate, np.zeros_like(drift), np.concatenate(times))
    return _rms(force), _rms(drift), _rms(rate)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
