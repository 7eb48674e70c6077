"""A part of the recordings, on which much is decided at a sixth of the cost."""

from __future__ import annotations

from dataclasses import replace

from twin.diagnosis.hypothesis import Hypothesis
from twin.estimation.fit import MOST_STEPS

PART = 1024
"""Samples of each recording that make the part: four seconds at 256 Hz, enough to tell resonances a
quarter of a hertz apart, and the blow of a hammer."""

SURE = 20.0
"""Odds [nat] by which a part settles what the rest would say as well: what is behind by as much is
right once in 5e8 cases."""

ROUGH = SURE / MOST_STEPS
"""Gain [nat] below which a step of a fit on the part is not worth another: as many as a fit may
take would not bring what settles anything."""


def beginning_of(hypothesis: Hypothesis) -> Hypothesis:
    """Return a hypothesis, its unknowns the same, beside the first samples of each recording."""
    problem = hypothesis.problem
    part = replace(problem, recordings=tuple(r.part(slice(PART)) for r in problem.recordings))
    return replace(hypothesis, problem=part)


def on_a_part(hypothesis: Hypothesis) -> Hypothesis | None:
    """Return the same, None where the part would be more than half of the samples."""
    part = beginning_of(hypothesis)
    return part if 2 * part.problem.samples <= hypothesis.problem.samples else None
