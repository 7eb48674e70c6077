"""Faults that are taken back in the samples: a channel that is late, a clock that is slow.

Between samples a reading is taken as band-limited. Where the inputs are not, the corners that they
give an acceleration at once are known: what is left of it is smooth, and only that is shifted.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.arrays import filled
from twin.diagnosis.problem import Problem
from twin.estimation.model import Trial
from twin.mechanisms.mechanism import ChannelFault

Array = NDArray[np.float64]


def mended(problem: Problem, faults: Sequence[ChannelFault]) -> tuple[Trial, ...]:
    """Return the recordings with faults taken back in their samples.

    Args:
        problem: whose recordings they are.
        faults: those of motors are done to what was commanded, the others undone.
    """
    names, split = (*problem.model.inputs, *problem.model.outputs), len(problem.model.inputs)
    out = []
    for recording in problem.recordings:
        hidden = np.isnan(recording.y)
        table = np.hstack([recording.u, filled(recording.y)])
        at_once = np.hstack([0 * recording.u, recording.u @ problem.feedthrough.T])
        columns = dict(zip(names, table.T, strict=True))
        known = dict(zip(names, at_once.T, strict=True))
        for fault in faults:
            if fault.of_motor:
                columns = fault.distort(columns, problem.sampling_hz)
            else:
                columns = _undone(problem, fault, columns, known)
        table = np.column_stack([columns[name] for name in names])
        u, y = table[:, :split], np.where(hidden, np.nan, table[:, split:])
        out.append(problem.trial(u, y))
    return tuple(out)


def _undone(
    problem: Problem, fault: ChannelFault, columns: dict[str, Array], known: dict[str, Array]
) -> dict[str, Array]:
    """Return the channels without a fault; ``known`` is what the inputs do to them at once."""
    if problem.between == "band_limited":
        return fault.undo(columns, problem.sampling_hz)
    spoiled = {n: _at(problem, known[n], fault) for n in fault.channels}
    rest = {n: x - spoiled[n] if n in spoiled else x for n, x in columns.items()}
    rest = fault.undo(rest, problem.sampling_hz)
    return {n: x + known[n] if n in spoiled else x for n, x in rest.items()}


def _at(problem: Problem, x: Array, fault: ChannelFault) -> Array:
    """Return a signal as it was at the moments that were recorded, (samples,)."""
    time = np.asarray(np.arange(len(x)) * problem.step_s, float)
    at = fault.moment(time) / problem.step_s
    if problem.between == "held":
        return np.asarray(x[np.clip(np.floor(at).astype(int), 0, len(x) - 1)])
    return np.asarray(np.interp(at, np.arange(len(x)), x))
