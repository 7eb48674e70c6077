"""Find what is missing: one mechanism after the other, until nothing is left to explain."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from twin.diagnosis.adjusting import REPRODUCIBLE, by_free_run, with_between, with_noise
from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.parameters import gravity_instead, several
from twin.diagnosis.refining import refined
from twin.diagnosis.stage import (
    DECISIVE,
    FURTHER_SAMPLE,
    LITTLE,
    TIE,
    Stage,
    is_narrow,
    next_stage,
)
from twin.diagnosis.unnamed import is_poor, runs_off, unnamed_law

RUNS_LESS = 0.75
"""Several parameters win over one mechanism, too, where the free run's error falls to this."""

STACKED = 2
"""When so many mechanisms together explain poorly, a further one will not help."""

HALF = 0.5
"""What runs better must also explain this share of the best fit's drop of the BIC."""

LENIENT = 1.2
"""All parameters free at once may run so much worse than the selection that is made of them."""

FURTHER_SHARE = 0.01
"""What a further mechanism must bring besides, as a share of all that was explained before. No
model of what was found first is exact: its own errors (the filters' phases, the integrator's
corners) must not be explained by more physics."""


@dataclass(frozen=True)
class Found:
    """What a search found: the fit of nothing missing, the best one, and how it was reached.

    ``bench`` is the one that it ended with: what inputs do between samples is chosen on the way.
    ``named`` is the best explanation by named mechanisms, where one without a name beats it.
    """

    nothing: Fit
    best: Fit
    stages: tuple[Stage, ...]
    bench: Bench
    named: Fit | None = None


def search(
    bench: Bench,
    base: Hypothesis,
    heights: Mapping[str, float],
    most: int = 5,
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
    bench, nothing = with_noise(*with_between(bench, nothing))
    current = nothing
    stages: list[Stage] = []
    for number in range(most):
        tell("locating" if number == 0 else "looking for a further mechanism")
        if number >= STACKED and is_poor(bench, nothing, current):
            break
        try:
            stage = next_stage(bench, current, heights, tell)
        except np.linalg.LinAlgError:
            if not stages:
                raise
            break
        if number == 0 and (many := _many(bench, nothing, stage, heights, tell)):
            current = many[-1].fits[0]
            stages += many
            continue
        stages.append(stage)
        needed = DECISIVE
        if stages[0] is not stage:
            explained = nothing.bic - current.bic
            needed += max(FURTHER_SAMPLE * bench.samples, FURTHER_SHARE * explained)
        allowed = [f for f in stage.fits if number == 0 or is_narrow(f.hypothesis.found[-1])]
        if not allowed or allowed[0].bic > current.bic - needed:
            break
        current = allowed[0]
        if stages[0] is stage:
            bench, current = by_free_run(*with_noise(*with_between(bench, current)))
    current, unnamed = unnamed_law(bench, nothing, current, stages, heights, tell)
    return Found(nothing, unnamed or current, tuple(stages), bench, current if unnamed else None)


def _many(
    bench: Bench,
    nothing: Fit,
    stage: Stage,
    heights: Mapping[str, float],
    tell: Callable[[str], None],
) -> list[Stage]:
    """Return one stage for each of several parameters, where they beat every single mechanism.

    A storey's lost stiffness may be the weight above it as well: that fit stands beside it, and in
    front where it is the better one by far.
    """
    if nothing.slack <= LITTLE and not stage.fits:
        return []
    tell("freeing the parameters")
    best = min(stage.fits, key=lambda f: f.bic, default=nothing)
    freely = min(RUNS_LESS * runs_off(bench, best), REPRODUCIBLE)

    def hopeless(loose: Fit) -> bool:
        least = -2 * loose.log_likelihood + 2 * np.log(bench.samples)
        return bool(
            least > best.bic - DECISIVE
            and (
                nothing.bic - least < HALF * _gain(nothing, best)
                or runs_off(bench, loose) > LENIENT * freely
            )
        )

    found = several(bench, nothing, hopeless)
    if found is None or len(found.hypothesis.found) < 2 or found.bic > nothing.bic - DECISIVE:
        return []
    others: list[Fit] = []
    for _ in found.hypothesis.found:
        others = gravity_instead(bench, found, heights)
        better = min(others, key=lambda f: f.bic, default=found)
        if better.bic > found.bic - TIE:
            break
        found = better
    freer = runs_off(bench, found) <= freely and _gain(nothing, found) > HALF * _gain(nothing, best)
    if found.bic > best.bic - DECISIVE and not freer:
        return []
    out = []
    for label in found.hypothesis.labels:
        tied = [f for f in others if f is not found and label not in f.hypothesis.labels]
        out.append(replace(stage, fits=(found, *tied)))
    return out


def _gain(nothing: Fit, found: Fit) -> float:
    """Return the drop of the BIC that an explanation brings."""
    return nothing.bic - found.bic
