"""Faults that are taken back in the samples: a channel that is late, a clock that is slow.

Between samples a reading is taken as band-limited. Where the inputs are not, the corners that they
give an acceleration at once are known: what is left of it is smooth, and only that is shifted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.arrays import filled
from twin.diagnosis.measured import Load
from twin.diagnosis.problem import Problem
from twin.diagnosis.straight import HoldError, read_error
from twin.diagnosis.trials import hold_errors, reread, trial_of
from twin.estimation.model import Trial
from twin.mechanisms.mechanism import ChannelFault
from twin.model.linear import LinearModel

Array = NDArray[np.float64]


def mended(problem: Problem, faults: Sequence[ChannelFault]) -> tuple[Trial, ...]:
    """Return the recordings with faults taken back in their samples.

    Args:
        problem: whose recordings they are.
        faults: those of motors are done to what was commanded, the others undone.
    """
    names, split = (*problem.model.inputs, *problem.model.outputs), len(problem.model.inputs)
    lines = problem.cornered & ~problem.held
    moved = any(fault.of_motor or set(fault.channels) & set(problem.model.inputs)
                for fault in faults)  # fmt: skip
    out = []
    for index, recording in enumerate(problem.recordings):
        hidden = _hidden(problem, faults, np.isnan(recording.y))
        table = np.hstack([recording.u, filled(recording.y)])
        known = [_at_once(problem, recording.u, at) for at in (problem.held, lines)]
        columns = dict(zip(names, table.T, strict=True))
        for fault in faults:
            if fault.of_motor:
                columns = fault.distort(columns, problem.sampling_hz)
            else:
                columns = _undone(problem, fault, columns, known)
        table = np.column_stack([columns[name] for name in names])
        u, y = table[:, :split], np.where(hidden, np.nan, table[:, split:])
        out.append(trial_of(problem, recording, u, y) if moved else reread(problem, index, y))
    return tuple(out)


def as_read(
    problem: Problem, faults: Sequence[ChannelFault], structure: LinearModel | None = None
) -> tuple[Trial, ...]:
    """Return the recordings, what is at fault in their samples taken back, as they are read.

    Args:
        problem: whose recordings they are.
        faults: of channels.
        structure: of which straight lines miss something; the nominal twin without.
    """
    wrong = [fault for fault in faults if fault.in_samples]
    trials = mended(problem, wrong) if wrong else problem.trials
    missing = None if structure is None else hold_errors(problem, structure)
    return read_as_lines(problem, trials, faults, missing)


def read_as_lines(
    problem: Problem, trials: Sequence[Trial], faults: Sequence[ChannelFault],
    missing: Mapping[Load, HoldError] | None = None,
) -> tuple[Trial, ...]:  # fmt: skip
    """Return recordings as instruments read the straight lines of smooth inputs.

    What the lines miss is read by an instrument without a memory as all else. One that rings near
    half the sampling rate hears their images, in what inputs do to an acceleration at once; what
    the structure does between samples is smooth.

    Args:
        problem: whose recordings they are.
        trials: the recordings.
        faults: of channels.
        missing: what the lines miss of the structure with each load; that of the nominal twin
            without.
    """
    if np.all(problem.cornered) or not (faults or missing):
        return tuple(trials)
    out, outputs = [], problem.model.outputs
    true = _true_inputs(problem, faults)
    as_measured = np.array_equal(true, np.eye(len(true)))
    same = missing is None and as_measured
    for index, (recording, trial) in enumerate(zip(problem.recordings, trials, strict=True)):
        before = np.zeros_like(trial.y) if trial.missed is None else trial.missed
        smooth = np.where(problem.cornered, 0.0, trial.u[:, : len(problem.cornered)])
        found = (missing or problem.hold_errors)[recording.load]
        if same:
            missed = before.copy()
        elif as_measured and trial.u is problem.trials[index].u:
            missed = found.of_spectrum(problem.spectra[index], len(smooth))
        else:
            missed = found.of(smooth @ true.T)
        for fault in faults:
            instrument = fault.instrument(0.0) if set(fault.channels) <= set(outputs) else None
            if instrument is None:
                continue
            at = [outputs.index(name) for name in fault.channels]
            if not np.any(instrument.B):
                missed[:, at] = missed[:, at] @ instrument.D.T
            elif len(at) == 1:
                push = smooth @ problem.feedthrough[at[0]]
                missed[:, at[0]] += read_error(instrument, push, problem.step_s)
        out.append(replace(trial, y=trial.y + before - missed, missed=missed))
    return tuple(out)


def _true_inputs(problem: Problem, faults: Sequence[ChannelFault]) -> Array:
    """Return the inputs by those that instruments at fault have measured, (r, r)."""
    inputs = problem.model.inputs
    out = np.eye(len(inputs))
    for fault in faults:
        instrument = fault.instrument(0.0) if set(fault.channels) <= set(inputs) else None
        if instrument is not None:
            rows = [inputs.index(name) for name in fault.channels]
            out[rows] = np.linalg.inv(instrument.D) @ out[rows]
    return out


def _hidden(
    problem: Problem, faults: Sequence[ChannelFault], hidden: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return which outputs are not known once readings are where they belong, (samples, m).

    What is hidden moves with its channel; where it was, what the inputs are is no better known.
    """
    out, time = hidden.copy(), np.asarray(np.arange(len(hidden)) * problem.step_s, float)
    for fault in faults:
        moment = fault.moment(time)
        if fault.of_motor or np.array_equal(moment, time):
            continue
        at = np.interp(time, moment, time) / problem.step_s
        around = np.floor(at).astype(int), np.ceil(at).astype(int).clip(max=len(time) - 1)
        for name in set(fault.channels) & set(problem.model.outputs):
            column = problem.model.outputs.index(name)
            for index in around:
                out[:, column] |= hidden[index, column]
    return out


def _at_once(problem: Problem, u: Array, some: NDArray[np.bool_]) -> dict[str, Array]:
    """Return what some of the inputs do to the outputs at once, output -> (samples,)."""
    seen = np.where(some, u, 0.0) @ problem.feedthrough.T
    return dict(zip(problem.model.outputs, seen.T, strict=True))


def _undone(
    problem: Problem, fault: ChannelFault, columns: dict[str, Array], known: list[dict[str, Array]]
) -> dict[str, Array]:
    """Return the channels without a fault; held and straight inputs do ``known`` at once."""
    held, lines = known
    if not np.any(problem.cornered) or not set(fault.channels) <= set(held):
        return fault.undo(columns, problem.sampling_hz)
    samples = len(next(iter(columns.values())))
    time = np.asarray(np.arange(samples) * problem.step_s, float)
    at = fault.moment(time) / problem.step_s
    before = np.clip(np.floor(at).astype(int), 0, samples - 1)
    rest = dict(columns)
    for n in fault.channels:
        rest[n] = rest[n] - held[n][before] - np.interp(at, np.arange(samples), lines[n])
    rest = fault.undo(rest, problem.sampling_hz)
    return {n: x + held[n] + lines[n] if n in fault.channels else x for n, x in rest.items()}
