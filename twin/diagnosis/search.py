"""Find what is missing: one mechanism after the other, until nothing is left to explain."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from twin.diagnosis.adjusting import REPRODUCIBLE, by_free_run, with_between, with_noise
from twin.diagnosis.bench import Bench
from twin.diagnosis.blurring import with_recorded_outputs, without_any_jumps, without_jumps
from twin.diagnosis.fitting import Fit, fit
from twin.diagnosis.following import follows_motion
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.parameters import gravity_instead, promoted, several, straightens
from twin.diagnosis.pruning import pruned
from twin.diagnosis.refining import refined
from twin.diagnosis.restarting import other_beginnings
from twin.diagnosis.stage import (
    DECISIVE,
    FURTHER_SAMPLE,
    LITTLE,
    TIE,
    Stage,
    has_friction,
    is_narrow,
    next_stage,
)
from twin.diagnosis.unnamed import foresees_off, is_poor, runs_off, unnamed_law

RUNS_LESS = 0.75
"""Several parameters win over one mechanism, too, where the free run's error falls to this."""

STACKED = 2
"""When so many mechanisms together explain poorly, a further one will not help."""

SEVERAL = 30.0
"""Drop of the BIC that several parameters must bring against any single mechanism."""

ENOUGH = 0.25
"""What runs better must also explain this share of the best fit's drop of the BIC."""

LENIENT = 1.2
"""All parameters free at once may run so much worse than the selection that is made of them."""

FURTHER_SHARE = 0.006
"""What a further mechanism must bring besides, as a share of all that was explained before. No
model of what was found first is exact: its own errors (the filters' phases, the integrator's
corners) must not be explained by more physics."""

STICKS = 0.05
"""The same of what comes third beside dry friction, the least exact of all."""

FORESEES = 0.7
"""A law must take the error two seconds ahead down to this share of a random force's."""


@dataclass(frozen=True)
class Found:
    """What a search found: the fit of nothing missing, the best one, and how it was reached.

    ``bench`` is the one that it ended with: what inputs do between samples is chosen on the way.
    ``named`` is the best explanation by named mechanisms, where one without a name beats it, and
    ``lost`` by how much the BIC is worse without each of its mechanisms.
    """

    nothing: Fit
    best: Fit
    stages: tuple[Stage, ...]
    bench: Bench
    named: Fit | None = None
    lost: tuple[float, ...] = ()


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
    tell("locating")
    stage = next_stage(bench, nothing, heights, tell)
    many = _many(bench, nothing, stage, heights, tell)
    lawful = stage if many else _lawful(bench, nothing, stage)
    follower = stage.fits[0] if lawful is not stage else None
    begun = tuple(many or [_foreseeing(bench, lawful)])
    path = _Path(bench, nothing, nothing, begun)
    ended = _followed(path, heights, most, tell)
    if not many:
        ended = _explaining(path, ended, heights, most, tell)
    tell("looking at what is needed still")
    best, stages, lost = pruned(ended.bench, ended.current, ended.stages, nothing.slack)
    best, unnamed = unnamed_law(ended.bench, nothing, best, stages, heights, tell, follower)
    bench = with_recorded_outputs(ended.bench, bench)
    return Found(nothing, unnamed or best, stages, bench, best if unnamed else None, lost)


@dataclass(frozen=True)
class _Path:
    """How far a search has come: the fit it started from, the one it stands at, and its stages."""

    bench: Bench
    nothing: Fit
    current: Fit
    stages: tuple[Stage, ...]


def _followed(
    path: _Path, heights: Mapping[str, float], most: int, tell: Callable[[str], None]
) -> _Path:
    """Take up the first fit of the stages begun, then add one mechanism after the other."""
    bench, nothing, stages = path.bench, path.nothing, list(path.stages)
    if not stages[-1].fits or stages[-1].fits[0].bic > nothing.bic - DECISIVE:
        return path
    current = stages[-1].fits[0]
    gained = _gain(nothing, current)  # noise levels change below: then the BICs no longer compare
    if len(stages) == 1:
        bench, current = by_free_run(*with_noise(*with_between(bench, current)))
    bench, current = without_jumps(bench, current)
    while len(stages) < most:
        if len(stages) >= STACKED and is_poor(bench, nothing, current):
            break
        tell("looking for a further mechanism")
        try:
            stage = next_stage(bench, current, heights, tell)
        except np.linalg.LinAlgError:
            break
        # a broad force is only what the models of what was found leave over
        allowed = tuple(f for f in stage.fits if is_narrow(f.hypothesis.found[-1]))
        if rough := has_friction(current):
            bench, current, allowed = without_any_jumps(bench, current, allowed)
        stages.append(replace(stage, before=current, fits=allowed))
        share = STICKS if rough and len(current.hypothesis.found) > 1 else FURTHER_SHARE
        needed = DECISIVE + max(FURTHER_SAMPLE * bench.samples, share * gained)
        better = [f for f in allowed if f.bic < current.bic - needed]
        # beside friction a parameter that is far off goes first, unless what is found explains it
        own = promoted(bench, current, needed) if rough or not better else None
        if own is not None and not (better and straightens(better[0], own)):
            stages[-1] = Stage(current, {}, (), (own,))
            current = own
        elif better:
            gained += current.bic - better[0].bic
            bench, current = without_jumps(bench, better[0])
        else:
            break
    return _Path(bench, nothing, current, tuple(stages))


def _explaining(
    path: _Path,
    ended: _Path,
    heights: Mapping[str, float],
    most: int,
    tell: Callable[[str], None],
) -> _Path:
    """Return where the search ended, or where it ends when it begins with something else.

    Another beginning is tried only as long as what there is explains poorly.
    """
    others = other_beginnings(path.bench, path.nothing, ended.stages[0])
    while is_poor(ended.bench, path.nothing, ended.current):
        if (other := next(others, None)) is None:
            break
        tell("looking again from another first mechanism")
        again = _followed(replace(path, stages=(other,)), heights, most, tell)
        if _comparable(path.bench, again.current).bic < _comparable(path.bench, ended.current).bic:
            ended = again
    return ended


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
        if any(trial.added_mass for trial in bench.trials):
            return False  # a weight that is left out shows now, and only beside the parameters
        least = -2 * loose.log_likelihood + 2 * np.log(bench.samples)
        return bool(
            least > best.bic - SEVERAL
            and (
                nothing.bic - least < ENOUGH * _gain(nothing, best)
                or runs_off(bench, loose) > LENIENT * freely
            )
        )

    found = several(bench, nothing, hopeless)
    if found is None or len(found.hypothesis.found) < 2 or found.bic > nothing.bic - SEVERAL:
        return []
    others: list[Fit] = []
    for _ in found.hypothesis.found:
        others = gravity_instead(bench, found, heights)
        better = min(others, key=lambda f: f.bic, default=found)
        if better.bic > found.bic - TIE:
            break
        found = better
    freer = runs_off(bench, found) <= freely and _gain(nothing, found) > ENOUGH * _gain(
        nothing, best
    )
    if found.bic > best.bic - SEVERAL and not freer:
        return []
    out = []
    for label in found.hypothesis.labels:
        tied = [f for f in others if f is not found and label not in f.hypothesis.labels]
        out.append(replace(stage, fits=(found, *tied)))
    return out


def _lawful(bench: Bench, nothing: Fit, stage: Stage) -> Stage:
    """Return the stage without broad forces, where the best fit is one that follows the motion."""
    if not stage.fits or is_narrow(stage.fits[0].hypothesis.found[-1]):
        return stage
    rest = tuple(f for f in stage.fits if is_narrow(f.hypothesis.found[-1]))
    if not rest or rest[0].bic > nothing.bic - DECISIVE:
        return stage
    return replace(stage, fits=rest) if follows_motion(bench, nothing, stage.fits[0]) else stage


def _foreseeing(bench: Bench, stage: Stage) -> Stage:
    """Return the stage with a law before an unmeasured force, where the law foresees far more.

    Broad noise fits whatever comes, law or not; but nothing foresees it.
    """
    if not stage.fits or is_narrow(stage.fits[0].hypothesis.found[-1]):
        return stage
    least = FORESEES * foresees_off(bench, stage.fits[0])
    missed = [(foresees_off(bench, f), i) for i, f in enumerate(stage.fits) if i]
    best = min(missed, default=(np.inf, 0))
    if best[0] > least:
        return stage
    chosen = stage.fits[best[1]]
    return replace(stage, fits=(chosen, *(f for f in stage.fits if f is not chosen)))


def _comparable(bench: Bench, found: Fit) -> Fit:
    """Return a fit on the bench of the first stage, whatever was chosen or left out on its way."""
    try:
        return fit(bench, found.hypothesis, found.slack, found.starts, iterations=1)
    except np.linalg.LinAlgError:
        return found


def _gain(nothing: Fit, found: Fit) -> float:
    """Return the drop of the BIC that an explanation brings."""
    return nothing.bic - found.bic
