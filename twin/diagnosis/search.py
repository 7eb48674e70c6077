"""Find what is missing: one mechanism after the other, until nothing is left to explain."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit, refined, with_slack
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.motion import motion_of
from twin.diagnosis.screen import Candidate, Scene, locate, screen

DECISIVE = 30.0
"""Drop of the BIC that a further mechanism must bring: odds of e^15, less the forty-odd pairs of
mechanism and place that were looked at, less what noise that is not quite white takes."""

REFINED = 5
"""Candidates that are fitted in full at each stage, at most."""

WORTH = 0.25
"""Candidates that promise less than this share of the best one's gain are not fitted in full."""


@dataclass(frozen=True)
class Stage:
    """One round of the search.

    Attributes:
        before: the fit that it started from.
        where: gain in log likelihood of a latent force at each place.
        candidates: all that were screened, the most promising first.
        fits: those that were fitted in full, the best first.
    """

    before: Fit
    where: Mapping[str, float]
    candidates: tuple[Candidate, ...]
    fits: tuple[Fit, ...]


@dataclass(frozen=True)
class Found:
    """What a search found: the fit of nothing missing, the best one, and how it was reached."""

    nothing: Fit
    best: Fit
    stages: tuple[Stage, ...]


def search(
    bench: Bench,
    base: Hypothesis,
    heights: Mapping[str, float],
    most: int = 3,
    tell: Callable[[str], None] = lambda message: None,
) -> Found:
    """Search for the mechanisms that explain the trials.

    Args:
        bench: model and trials.
        base: the hypothesis that nothing is missing.
        heights: of the storeys [m].
        most: mechanisms that are looked for, at most.
        tell: is told what is being done.
    """
    tell("calibrating")
    nothing = refined(bench, [base], 3e-3)
    current = nothing
    stages = []
    for number in range(most):
        tell("locating" if number == 0 else "looking for a further mechanism")
        stage = _stage(bench, current, heights, tell)
        stages.append(stage)
        if not stage.fits or stage.fits[0].bic > current.bic - DECISIVE:
            break
        current = stage.fits[0]
    return Found(nothing, current, tuple(stages))


def _stage(
    bench: Bench, current: Fit, heights: Mapping[str, float], tell: Callable[[str], None]
) -> Stage:
    moved, known, plain = motion_of(bench, current)
    plain = with_slack(known, plain)
    scene = Scene(known, plain, tuple(moved), heights)
    where = locate(scene)
    candidates = screen(scene, without=current.hypothesis.labels)
    fits = []
    promising = [c for c in candidates if c.gain > DECISIVE / 4]
    for candidate in promising[:REFINED]:
        if candidate.gain < WORTH * promising[0].gain:
            break
        tell(f"fitting {candidate.label[0]} at {candidate.label[1]}")
        found = _fitted(bench, current, candidate)
        if found is not None:
            fits.append(found)
    fits.sort(key=lambda f: f.bic)
    return Stage(current, where, tuple(candidates), tuple(fits))


def _fitted(bench: Bench, current: Fit, candidate: Candidate) -> Fit | None:
    """Fit a candidate on top of what was found, all parameters free."""
    as_it_was = current.hypothesis
    starts = [as_it_was.including(candidate.mechanism)]
    if candidate.hypothesis is not None:
        # laws of earlier stages were known forces in the screening: keep their values
        along = replace(as_it_was, base=candidate.hypothesis.base)
        starts.append(along.including(candidate.mechanism))
    level = replace(as_it_was, base=tuple(m.with_values({"change": 0.0}) for m in as_it_was.base))
    starts.append(level.including(candidate.mechanism))
    try:
        return refined(bench, starts, current.slack, current.starts)
    except (np.linalg.LinAlgError, ValueError, FloatingPointError):
        return None
