"""The error on recordings that were not seen, stated before they are compared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.predict import placed
from twin.diagnosis.problem import Problem
from twin.diagnosis.simulation import OutputError

Array = NDArray[np.float64]


def stated_error(
    hypothesis: Hypothesis, z: Array, tau: float, unseen: Problem, linear: tuple[Hypothesis, Array]
) -> float:
    """Return the NRMSE that unseen recordings will have, by the training recordings and inputs.

    Three parts, RMS: what the simulation leaves of the training recordings, for no law is exact; by
    how much its predictions of the unseen motion scatter when each training recording is left out
    in turn (jackknife, Efron and Stein 1981); and, for the share of the motion that goes farther
    than any in training, its difference from the linear twin's, than which a law is no better known
    where no recording showed it.

    Args:
        hypothesis: what was found.
        z: values of its unknowns, (p,).
        tau: share of the samples that count.
        linear: the calibrated twin without laws, and values of its unknowns.
        unseen: the recordings to predict; their outputs are not used.
    """
    problem = hypothesis.problem
    count = len(problem.recordings)
    left = sum(float(np.sum(r**2)) for r in OutputError(hypothesis).residuals(z))
    share = left / sum(float(np.nansum(r.y**2)) for r in problem.recordings)
    silent = replace(unseen, recordings=tuple(replace(r, y=0 * r.y) for r in unseen.recordings))

    def predicted(part: Hypothesis, values: Array) -> Array:
        there, own = placed(part, values, silent)
        return np.vstack(OutputError(there).residuals(own))

    whole = predicted(hypothesis, z)
    scatter = 0.0
    for out in range(count):
        rest = [t for t in range(count) if t != out]
        if not rest:
            break
        fewer = tuple(problem.recordings[t] for t in rest)
        part, start = placed(
            hypothesis, z, replace(problem, recordings=fewer, scale=problem.scale[rest])
        )
        moved = predicted(part, OutputError(part, tau).fitted(start).z) - whole
        scatter += (count - 1) / count * float(np.sum(moved**2) / np.sum(whole**2))
    straight = predicted(*linear) - whole
    apart = float(np.sum(straight**2) / np.sum(whole**2))
    return float(np.sqrt(share + scatter + beyond(hypothesis, z, silent) * apart))


def beyond(hypothesis: Hypothesis, z: Array, unseen: Problem) -> float:
    """Return the share of the motion at laws' ports, by power, outside what training showed.

    Args:
        hypothesis: what was found.
        z: values of its unknowns, (p,).
        unseen: the recordings to predict.
    """
    there, own = placed(hypothesis, z, unseen)
    shown, coming = OutputError(hypothesis).motion(z), OutputError(there).motion(own)
    largest = 0.0
    for law in hypothesis.laws:
        row = hypothesis.problem.model.port(law.place)
        reach = max(float(np.max(np.abs(m.q @ row))) for m in shown)
        power = np.concatenate([(m.q @ row) ** 2 for m in coming])
        largest = max(largest, float(power[power > reach**2].sum() / max(power.sum(), 1e-300)))
    return largest
