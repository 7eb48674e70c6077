"""Forces of laws along an estimated motion, and what they do to the innovations."""

# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.motion import Motion
from twin.estimation.laws import memory_along
from twin.estimation.passing import Run
from twin.mechanisms.mechanism import Law

Array = NDArray[np.float64]


def force_along(law: Law, row: Array, motion: Motion, step_s: float) -> Array:
    """Return the force of a law along a motion, (samples,)."""
    drift, rate = motion.q[:, : len(row)] @ row, motion.v[:, : len(row)] @ row
    memory = memory_along(law.compiled, np.array(law.numbers), drift)
    time = np.asarray(np.arange(len(drift)) * step_s, float)
    return np.broadcast_to(law.force(drift, rate, memory, time), drift.shape)


def respond(run: Run, hypothesis: Hypothesis, trial: int, rows: Array, forces: Array) -> Array:
    """Return the change of the innovations by small forces at ports, (samples, m, c)."""
    system, plant = run.sampled.system, run.sampled
    n = rows.shape[1]
    # a force on the coordinates enters as process noise does, which is held over a sample
    inputs = len(hypothesis.problem.model.inputs)
    size = system.W.shape[1] - inputs
    wide = np.zeros((size, len(rows)))
    wide[:n] = -rows.T
    entry = plant.entry[:, inputs:] @ wide
    through = system.V[:, inputs:] @ wide
    K = plant.whole @ run.gains.state[-1] + plant.entry @ run.gains.held[-1]
    out = np.empty((len(forces), system.C.shape[0], len(rows)))
    c = np.ascontiguousarray
    _recurse(c(plant.whole - K @ system.C), c(K), c(system.C), c(entry), c(through), c(forces), out)
    return out


@numba.njit(nogil=True, cache=True)
def _recurse(closed, K, C, entry, through, forces, out):
    n, m, count = closed.shape[0], C.shape[0], forces.shape[1]
    x, after = np.zeros((n, count)), np.zeros((n, count))
    for k in range(len(forces)):
        for o in range(m):
            for c in range(count):
                out[k, o, c] = -through[o, c] * forces[k, c]
            for i in range(n):
                g = C[o, i]
                for c in range(count):
                    out[k, o, c] -= g * x[i, c]
        middle = min(k + 1, len(forces) - 1)
        for i in range(n):
            for c in range(count):
                after[i, c] = entry[i, c] * 0.5 * (forces[k, c] + forces[middle, c])
            for j in range(n):
                g = closed[i, j]
                for c in range(count):
                    after[i, c] += g * x[j, c]
            for o in range(m):
                g = K[i, o]
                for c in range(count):
                    after[i, c] -= g * through[o, c] * forces[k, c]
        for i in range(n):
            for c in range(count):
                x[i, c] = after[i, c]
