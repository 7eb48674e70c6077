"""What straight lines between samples miss, by the structure that a fit found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import attempted
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.plant import structure_of
from twin.estimation.fit import WORTH, Fit

Array = NDArray[np.float64]

ROUNDS = 8
"""Fits at most, each with what the lines miss by the one before: where a change is large enough to
ask for more, the model is another one than where it began."""

STEPS = 6
"""Of each, which begins where the one before ended; the last one goes on to its end."""


def by_its_lines(h: Hypothesis, z: Array) -> Hypothesis:
    """Return a hypothesis for which straight lines miss what its structure at values z misses.

    The same where there is no such structure. It matters where modes lie above half the sampling
    rate: the lines' error is corrected for (``straight.hold_error``), to first order by a structure
    nearby.

    Args:
        h: the hypothesis.
        z: values of its unknowns, (p,).
    """
    problem = h.problem
    if not problem.calmed:
        return h
    try:
        base = problem.base(z[: len(problem.base_unknowns)])
        structure = structure_of(base, (*h.at(z), *problem.known_at(z)))
    except (ValueError, np.linalg.LinAlgError):
        return h
    return replace(h, problem=replace(problem, fitted=structure))


def with_its_lines(h: Hypothesis, found: Fit) -> tuple[Hypothesis, Fit]:
    """Return a fit for which straight lines miss what its own structure misses."""
    for _ in range(ROUNDS if h.problem.calmed else 0):
        other = by_its_lines(h, found.z)
        moved = attempted(other, found.z, STEPS, near=found.averages or None)
        if moved is None or not np.isfinite(moved.log_evidence):
            break
        gained = moved.log_evidence - found.log_evidence
        h, found = other, moved
        if abs(gained) < WORTH:
            break
    if found.code == "stopped" and h.problem.calmed:
        found = attempted(h, found.z, near=found.averages or None) or found
    return h, found
