"""Wrong samples that only the twin tells: one reading is off, and nothing before or after it is.

Where a blow is near, or a record begins, a channel's own samples do not show it; the innovations of
what was found do. A wrong sample leaves what the predictor makes of it, a force that nobody
measured leaves what the structure makes of that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.problem import Problem
from twin.diagnosis.read_off import ReadOff
from twin.estimation.law_averages import LawAverages
from twin.estimation.likelihood import passes
from twin.estimation.passing import Run
from twin.mechanisms.sensor_spikes import SensorSpikes
from twin.signals.whitening import HALF, local_scale, noise_level

Array = NDArray[np.float64]

WINDOW = 32
"""Samples of the innovations that a sample and a force are told by."""

LASTS = 3
"""Samples that a blow at a stop may last, one before the sample it is seen in."""


def without_wrong(
    hypothesis: Hypothesis, z: Array, averages: Sequence[LawAverages] | None = None
) -> tuple[Problem, tuple[ReadOff, ...], float]:
    """Return a problem without the samples that are wrong beside a hypothesis.

    Args:
        hypothesis: what was found.
        z: its values, (p,).
        averages: of its laws, as the fit ended with them; found anew without.

    Returns:
        The problem, the faults, and what they cost beforehand [nat]: any sample may be wrong, and
        read anything within the channel's range.
    """
    problem = hypothesis.problem
    runs, cost = passes(hypothesis, z, averages), 0.0
    recordings, faults = list(problem.recordings), list[ReadOff]()
    for index, (measured, run) in enumerate(zip(problem.recordings, runs, strict=True)):
        y, wrong = np.array(measured.y), _wrong(run, measured.y, len(problem.model.inputs))
        for column, place in enumerate(problem.model.outputs):
            at = [(k, size) for k, c, size in wrong if c == column]
            if not at:
                continue
            height = float(np.max(np.abs([size for _, size in at])))
            often = len(at) / (len(y) * problem.step_s)
            span = float(np.nanmax(y[:, column]) - np.nanmin(y[:, column]))
            cost += len(at) * float(np.log(y.size * span))
            fault = SensorSpikes(place, height, often)
            faults.append(ReadOff(measured.name, fault, len(at), len(at) / len(y)))
            y[[k for k, _ in at], column] = np.nan
        recordings[index] = replace(measured, y=y)
    if not faults:
        return problem, (), 0.0
    return replace(problem, recordings=tuple(recordings)), tuple(faults), cost


def _wrong(run: Run, y: Array, inputs: int) -> list[tuple[int, int, float]]:
    """Return sample, output and size of what is wrong, the clearest first.

    Args:
        run: the predictor's pass.
        y: what was measured, (samples, m).
        inputs: how many there are: their noise is no force.
    """
    left = np.where(np.isnan(y), 0.0, run.e)
    samples, m = left.shape
    if samples < 4 * HALF:
        return []
    # where a law jumps or acts a sample may be off without being wrong
    inverse = np.linalg.inv(run.covariances)
    # each output beside the others at the same time
    alone = np.einsum("ki,kij->kj", left, inverse)
    alone /= np.sqrt(np.diagonal(inverse, axis1=1, axis2=2))
    scale = np.column_stack([local_scale(alone[:, c]) for c in range(m)])
    size = np.abs(alone) / np.maximum(scale, 1e-300)
    places = np.argwhere(size > noise_level(left.size))
    found: list[tuple[int, int, float]] = []
    for k, c in places[np.argsort(-size[tuple(places.T)])].tolist():
        begin = max(k - 1, 0)
        white = np.linalg.cholesky(inverse[begin : begin + WINDOW])
        wrong, force = _signatures(run, k, c, begin, len(white), inputs)

        def whitened(x: Array, white: Array = white) -> Array:
            return np.einsum("kiq,kij->kjq", x, white).reshape(-1, x.shape[2])

        own = whitened(wrong[:, :, None])[:, 0]
        there = whitened(left[begin : begin + WINDOW, :, None])[:, 0]
        power = float(np.max(scale[k : k + WINDOW])) ** 2
        height = float(own @ there) / float(own @ own)
        told = 0.5 * height**2 * float(own @ own) / power
        blows = whitened(force)
        made = blows @ np.linalg.lstsq(blows, there, rcond=None)[0]
        if told - 0.5 * float(made @ made) / power > np.log(left.size):
            left[begin : begin + WINDOW] -= height * wrong
            found.append((k, c, height))
    return found


def _signatures(
    run: Run, k: int, output: int, begin: int, count: int, inputs: int
) -> tuple[Array, Array]:
    """Return what a wrong sample, and forces about it, leave: (count, m), (count, m, forces).

    Forces act on any coordinate, in any of the samples that a blow may last.

    Args:
        run: the predictor's pass.
        k: the sample.
        output: of it.
        begin: from which sample on.
        count: of samples.
        inputs: how many there are: their noise is no force.
    """
    plant, system, last = run.sampled, run.sampled.system, len(run.gains.state) - 1
    entry, through = plant.entry[:, inputs:], system.V[:, inputs:]
    n, forces = entry.shape
    x, out = np.zeros((n, LASTS * forces + 1)), np.zeros((count, len(system.C), LASTS * forces + 1))
    for at in range(count):
        now = min(begin + at, last)
        K = plant.whole @ run.gains.state[now] + plant.entry @ run.gains.held[now]
        out[at] = system.C @ x
        x = plant.whole @ x
        if at < LASTS:
            columns = slice(at * forces, (at + 1) * forces)
            out[at][:, columns] += through
            x[:, columns] += entry
        out[at, output, -1] += begin + at == k
        x -= K @ out[at]
    return out[:, :, -1], out[:, :, :-1]
