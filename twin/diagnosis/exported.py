"""A hypothesis as a MuJoCo twin, and MuJoCo's own free run of it from the measured inputs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.known import differences
from twin.diagnosis.measured import Measured
from twin.diagnosis.problem import Between, Problem
from twin.diagnosis.scales import ROUNDING
from twin.errors import ModelError
from twin.mechanisms.damping import Damping
from twin.mechanisms.mass import Mass
from twin.mechanisms.mechanism import ChannelFault, Mechanism, StructuralChange
from twin.mechanisms.stiffness import Stiffness
from twin.model import Motion, Twin
from twin.model.linear import LinearModel
from twin.model.port import ground_inputs
from twin.signals.resampling import resample

Array = NDArray[np.float64]

FINEST_S = 1e-3
"""Longest step of a simulation [s]."""

FINEST = 100
"""Steps in the period of the highest mode below half the sampling rate: Runge-Kutta's phase error
is (2 pi / 100)^4 / 120 a radian."""

STABLE = 4
"""Steps in the period of any mode: Runge-Kutta is stable from 2.2 on, and what lies above half the
sampling rate follows its forces."""

WHOLE = 0.99
"""Share of the band in which inputs and outputs are kept: an analyser passes half at its end, and a
blow has as much there as anywhere."""

HELD_STEPS = 16
"""Pieces of a sampling interval in which a held input is played back."""


def base_mechanisms(problem: Problem, z: Array) -> tuple[Mechanism, ...]:
    """Return what differs from the nominal twin at values z of the base unknowns, (p,)."""
    out: list[Mechanism] = []
    at = 0
    for name, _, k in problem.stiffnesses:
        out.append(Stiffness(name, float(k * np.expm1(problem.tolerance * z[at]))))
        at += 1
    for name, body in problem.masses:
        out.append(Mass(name, float(body.mass * np.expm1(problem.tolerance * z[at])), 1.0))
        at += 1
    there = problem.base(z)
    change = problem.damping(there.M, there.K, z) - problem.model.R
    return (*out, *dashpots(problem.model, change))


def dashpots(model: LinearModel, change: Array) -> tuple[Damping, ...]:
    """Return dashpots along ports that change R by a symmetric matrix, (n, n), as nearly as can be.

    Relative motions come first, then absolute ones, then those between two places.
    """
    if not np.any(change):
        return ()
    motions = [p for p in model.ports.values() if p.kind == "motion"]
    rows = {p.name: p.row for p in model.ports.values() if p.kind == "drift"}
    rows |= {p.name: p.row for p in motions}
    for i, a in enumerate(motions):
        rows |= {f"{a.name}-{b.name}": a.row - b.row for b in motions[i + 1 :] if a.unit == b.unit}
    names, patterns, basis = [], [], np.zeros((change.size, 0))
    most = len(change) * (len(change) + 1) // 2
    for name, row in rows.items():
        pattern = np.outer(row, row).ravel()
        size = float(np.linalg.norm(pattern))
        rest = pattern - basis @ (basis.T @ pattern)
        if size and np.linalg.norm(rest) ** 2 > ROUNDING * size**2:
            names.append(name)
            patterns.append(pattern)
            basis = np.column_stack([basis, rest / np.linalg.norm(rest)])
        if len(names) == most:
            break
    values = np.linalg.lstsq(np.array(patterns).T, change.ravel(), rcond=None)[0]
    return tuple(Damping(name, float(c)) for name, c in zip(names, values, strict=True))


def twin_of(twin: Twin, hypothesis: Hypothesis, z: Array) -> Twin:
    """Return the twin that a hypothesis is at values z of its unknowns, (p,)."""
    problem = hypothesis.problem
    more = differences(problem.known, problem.known_at(z))
    return including(twin, (*base_mechanisms(problem, z), *more, *hypothesis.at(z)))


def including(twin: Twin, mechanisms: Sequence[Mechanism]) -> Twin:
    """Return a twin with further mechanisms; changes of one kind at one place are added up."""
    kept: list[Mechanism] = []
    for mechanism in (*twin.mechanisms, *mechanisms):
        changes = isinstance(mechanism, StructuralChange) and "change" in mechanism.parameters
        same = [
            m
            for m in kept
            if changes
            and type(m) is type(mechanism)
            and m.with_values({"change": 0.0}) == mechanism.with_values({"change": 0.0})
        ]
        if changes and same:
            total = same[0].values["change"] + mechanism.values["change"]
            kept[kept.index(same[0])] = same[0].with_values({"change": total})
        elif not changes or mechanism.values["change"]:
            kept.append(mechanism)
    return replace(twin, mechanisms=()).including(*kept)


def in_mujoco(twin: Twin, problem: Problem, recording: Measured) -> Array:
    """Return MuJoCo's outputs from rest, as the instruments record them, (samples, m).

    They are NaN throughout where the motion diverges.
    """
    names, rate = problem.model.inputs, problem.sampling_hz
    columns = dict(zip(names, recording.u.T, strict=True))
    for fault in twin.mechanisms:
        if isinstance(fault, ChannelFault) and set(fault.channels) <= set(columns):
            columns = columns if fault.of_motor else fault.undo(columns, rate)
    seen = problem.frequencies[problem.frequencies < rate / 2]
    steps = (FINEST * float(np.max(seen, initial=0.0)), STABLE * float(problem.frequencies[-1]))
    fine = max(1, math.ceil(max(1 / FINEST_S, *steps) / rate - 1e-9))
    u = np.column_stack([columns[name] for name in names])
    played, faster = _played(u, rate, fine, problem.between)
    loaded = including(twin, _added(recording))
    try:
        motion = simulated(loaded, problem.model, played, faster)
    except ModelError as error:
        if "diverges" not in str(error):
            raise
        return np.full(recording.y.shape, np.nan)
    step = round(faster / rate)
    samples = len(u)
    read = {}
    for column, name in enumerate(problem.model.outputs):
        values = motion.column(name)
        if not np.all(problem.cornered):
            values = resample(values, faster, rate, WHOLE)[:samples]
            values = np.concatenate([values, np.repeat(values[-1:], samples - len(values))])
        else:
            values = values[::step][:samples]
        read[name] = values - problem.model.rest[column]
    recorded = loaded.recorded({**columns, **read}, rate)
    return np.column_stack([recorded[name] for name in problem.model.outputs])


def _added(recording: Measured) -> tuple[Mass, ...]:
    return tuple(Mass(place, kg) for place, kg in recording.added_mass.items())


def _played(u: Array, rate: float, fine: int, between: Sequence[Between]) -> tuple[Array, float]:
    """Return the inputs as they are between the samples, and their rate."""
    if set(between) == {"linear"}:
        return u, rate
    if "band_limited" not in between:
        fine = HELD_STEPS
    times = np.arange(fine * len(u)) / fine
    out = np.empty((len(times), u.shape[1]))
    for i, kind in enumerate(between):
        if kind == "held":
            out[:, i] = np.repeat(u[:, i], fine)
        elif kind == "linear":
            out[:, i] = np.interp(times, np.arange(len(u)), u[:, i])
        else:
            whole = resample(u[:, i : i + 1], rate, rate * fine, WHOLE)[:, 0]
            out[:, i] = np.concatenate([whole, np.full(fine - 1, whole[-1])])
    return out, rate * fine


def simulated(twin: Twin, model: LinearModel, u: Array, rate_hz: float) -> Motion:
    """Simulate in MuJoCo with inputs in the model's order, (samples, r)."""
    shaken = ground_inputs(model.inputs, model.base)
    ground = {axis: u[:, column] for axis, column in shaken.items()}
    forces = {n: u[:, i] for i, n in enumerate(model.inputs) if i not in shaken.values()}
    return twin.simulate(forces, rate_hz, len(u), ground or None)
