"""What small forces at ports do to the innovations of a fit."""

# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.hypothesis import Hypothesis
from twin.estimation.passing import Run
from twin.estimation.products import add_product

Array = NDArray[np.float64]


def respond(run: Run, hypothesis: Hypothesis, rows: Array, forces: Array) -> Array:
    """Return the change of the innovations by small forces at ports, (samples, m, c).

    Args:
        run: the fit's pass over a recording.
        hypothesis: what was fitted.
        rows: ports, (c, n).
        forces: along the motion, (samples, c); between samples they are straight lines.
    """
    system, plant = run.sampled.system, run.sampled
    n = rows.shape[1]
    # a force on the coordinates enters as process noise does, which is held over a sample
    inputs = len(hypothesis.problem.model.inputs)
    wide = np.zeros((system.W.shape[1] - inputs, len(rows)))
    wide[:n] = -rows.T
    K = plant.whole @ run.gains.state[-1] + plant.entry @ run.gains.held[-1]
    out = np.empty((len(forces), system.C.shape[0], len(rows)))
    c = np.ascontiguousarray
    _recurse(
        c(plant.whole - K @ system.C), c(-K), c(-system.C), plant.entry[:, inputs:] @ wide,
        system.V[:, inputs:] @ wide, c(forces), out,
    )  # fmt: skip
    return out


@numba.njit(nogil=True, cache=True)
def _recurse(closed, minus_K, minus_C, entry, through, forces, out):
    n, m = entry.shape[0], len(through)
    x = np.zeros(entry.shape)
    for k in range(len(forces)):
        following = forces[min(k + 1, len(forces) - 1)]
        direct = through * forces[k]
        out[k] = -direct
        add_product(out[k], minus_C, 0, x, n)
        after = entry * (0.5 * (forces[k] + following))
        add_product(after, closed, 0, x, n)
        add_product(after, minus_K, 0, direct, m)
        x = after
