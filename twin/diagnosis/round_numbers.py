"""Whether a shaken structure's model has round numbers, by its natural frequencies.

A motion of the ground tells frequencies well, though masses and stiffnesses hardly apart. One local
effect changes the stiffness or the mass of one place, K + k p p^T; where no such change brings the
model's frequencies to those that the recordings show, to within the half-power width, more than
one of its numbers is off.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.by_simulation import calibrated_model
from twin.diagnosis.prepare import HALF_POWER
from twin.diagnosis.problem import Problem

Array = NDArray[np.float64]

CHANGES = np.geomspace(0.1, 10.0, 1 + round(np.log(100) / HALF_POWER))
"""What a local effect may make of a stiffness or a mass, as a factor: in steps of which each moves
a frequency by half of the half-power width at most."""


def has_round_numbers(problem: Problem) -> bool:
    """Return whether more than one of the model's masses and stiffnesses is off.

    Args:
        problem: where they may be anything, in the band of the motion.
    """
    model, found = problem.model, calibrated_model(problem)
    there = _frequencies(found.M, found.K)
    nominal = _frequencies(model.M, model.K)
    seen = (nominal > 0) & (nominal < problem.sampling_hz / 2)

    def near(M: Array, K: Array) -> bool:
        ratio = _frequencies(M, K)[seen] / there[seen]
        return bool(np.all(np.abs(np.log(ratio)) < HALF_POWER))

    return not any(near(M, K) for M, K in _changed(problem))


def _changed(problem: Problem) -> Iterator[tuple[Array, Array]]:
    """Yield mass and stiffness matrices, each with one number changed."""
    M, K = problem.model.M, problem.model.K
    for factor in CHANGES:
        for _, row, k in problem.stiffnesses:
            yield M, K + (factor - 1) * k * np.outer(row, row)
        for _, body in problem.masses:
            rows = body.translation
            yield M + (factor - 1) * (body.mass * rows.T @ rows + body.spin), K


def _frequencies(M: Array, K: Array) -> Array:
    """Return natural frequencies [Hz], ascending, (n,)."""
    values = np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)
    return np.asarray(np.sqrt(np.maximum(values, 1e-12)) / (2 * np.pi))
