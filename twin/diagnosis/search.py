"""Find what is missing: one mechanism after the other, until nothing is left to explain."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from twin.diagnosis.adjusting import REPRODUCIBLE, by_free_run, with_between, with_noise
from twin.diagnosis.base import surroundings
from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.locating import locate
from twin.diagnosis.motion import motion_of
from twin.diagnosis.parameters import gravity_instead, several
from twin.diagnosis.predict import ahead, from_rest, nrmse
from twin.diagnosis.refining import refined, with_slack
from twin.diagnosis.scene import Candidate, Scene
from twin.diagnosis.screen import screen
from twin.physics.mechanism import Disturbance, Mechanism
from twin.physics.restoring_force import RestoringForce

DECISIVE = 30.0
"""Drop of the BIC that a mechanism must bring: odds of e^15, less the forty-odd pairs of mechanism
and place that were looked at, less what noise that is not quite white takes."""

FORESEES = 0.7
"""A law must take the error two seconds ahead down to this share of a random force's."""

RUNS_LESS = 0.75
"""Several parameters win over one mechanism, too, where the free run's error falls to this."""

LENIENT = 1.2
"""All parameters free at once may run so much worse than the selection that is made of them."""

TIE = 6.0
"""Difference of the BIC below which two explanations tie: odds of 20."""

FURTHER_SAMPLE = 0.01
FURTHER_SHARE = 0.01
"""What a further mechanism must bring besides: a drop of the BIC of this much a sample, and of this
share of all that was explained before. No model of what was found first is exact: its own errors
(the filters' phases, the integrator's corners) must not be explained by more physics."""

UNNAMED = 200.0
UNNAMED_SHARE = 0.02
"""What a law without a name must bring beyond the best that has one, and as a share of what that
one explains: it is flexible enough to take up a named law's small inexactness."""

REFINED = 4
"""Candidates that are fitted in full at each stage, at most, besides one unmeasured force."""

WORTH = 0.1
"""Candidates that promise less than this share of the best one's gain are not fitted in full."""

LITTLE = 1e-3
"""Slack up to which a filter trusts its model as it stands."""

NARROW_HZ = 0.5
"""An unmeasured force that is found beside something else must have a narrower band than this: a
broad one is only what the first finding's model leaves over."""


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
    stages = []
    for number in range(most):
        tell("locating" if number == 0 else "looking for a further mechanism")
        stage = _stage(bench, current, heights, tell)
        if number == 0 and (many := _many(bench, nothing, stage, heights, tell)):
            current = many[-1].fits[0]
            stages += many
            continue
        stages.append(stage)
        needed = DECISIVE
        if stages[0] is not stage:
            explained = nothing.bic - current.bic
            needed += max(FURTHER_SAMPLE * bench.samples, FURTHER_SHARE * explained)
        allowed = [f for f in stage.fits if number == 0 or _narrow(f.hypothesis.found[-1])]
        if not allowed or allowed[0].bic > current.bic - needed:
            break
        current = allowed[0]
        if stages[0] is stage:
            bench, current = by_free_run(*with_noise(*with_between(bench, current)))
    current, unnamed = _unnamed(bench, nothing, current, stages, heights, tell)
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
    freely = min(RUNS_LESS * _runs(bench, best), REPRODUCIBLE)

    def hopeless(loose: Fit) -> bool:
        least = -2 * loose.log_likelihood + 2 * np.log(bench.samples)
        return bool(least > best.bic - DECISIVE and _runs(bench, loose) > LENIENT * freely)

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
    if found.bic > best.bic - DECISIVE and _runs(bench, found) > freely:
        return []
    out = []
    for label in found.hypothesis.labels:
        tied = [f for f in others if f is not found and label not in f.hypothesis.labels]
        out.append(replace(stage, fits=(found, *tied)))
    return out


def _unnamed(
    bench: Bench,
    nothing: Fit,
    best: Fit,
    stages: Sequence[Stage],
    heights: Mapping[str, float],
    tell: Callable[[str], None],
) -> tuple[Fit, Fit | None]:
    """Return the best fit with names, and that of a law without one where it beats it by far.

    It is tried where a latent force enters best, and only when the best explanation leaves its
    filter something to follow.
    """
    explained = nothing.bic - best.bic
    last = stages[-1]
    broad = bool(best.hypothesis.found) and not _narrow(best.hypothesis.found[0])
    done = not best.hypothesis.found or (best.slack <= LITTLE and last.before is best
                                         and _explained(best, last.where, bench))  # fmt: skip
    if (done and not broad) or not _about_motion(best):
        return best, None
    moved, known, plain = motion_of(bench, nothing)
    scene = Scene(known, plain, tuple(moved), heights)
    motion = scene.motion()
    storeys = [p for p in stages[0].where if p.startswith("storey")]
    storeys.sort(key=lambda p: -stages[0].where[p])
    found = []
    for place in storeys[:2]:
        tell(f"fitting a law without a name at {place}")
        (start,) = RestoringForce.starts(place, surroundings(bench, motion, heights, place))
        fitted = _fitted(bench, nothing, Candidate(start, 0.0))
        if fitted is not None:
            found.append(fitted)
    if not found:
        return best, None
    unnamed = min(found, key=lambda f: f.bic)
    if unnamed.bic < best.bic:
        # the flexible law may have found the way that the named one missed
        along = replace(best.hypothesis, base=unnamed.hypothesis.base)
        with suppress(np.linalg.LinAlgError):
            again = refined(bench, [along], unnamed.slack, unnamed.starts)
            best = min(best, again, key=lambda f: f.bic)
    if broad and _foresees(bench, unnamed) < FORESEES * _foresees(bench, best):
        return best, unnamed  # a force that follows the motion is a law, however well noise fits
    needed = max(UNNAMED, UNNAMED_SHARE * explained)
    return best, unnamed if unnamed.bic < best.bic - needed else None


def _runs(bench: Bench, found: Fit) -> float:
    """Return the error of the free run over the training recordings."""
    value = nrmse(bench.trials, from_rest(bench, found.hypothesis, found.slack))
    return value if np.isfinite(value) else np.inf


def _foresees(bench: Bench, found: Fit) -> float:
    """Return the error two seconds ahead on the training recordings."""
    value = nrmse(bench.trials, ahead(bench, found.hypothesis, found.slack, found.starts))
    return value if np.isfinite(value) else np.inf


def _about_motion(best: Fit) -> bool:
    """Return whether the explanation is one of forces: a faulty channel is no law of motion."""
    return all(m.verdict in ("missing_physics", "parameter") for m in best.hypothesis.found)


def _narrow(mechanism: Mechanism) -> bool:
    """Return whether a mechanism is no disturbance, or one in a narrow band."""
    return not isinstance(mechanism, Disturbance) or mechanism.oscillator()[1] < NARROW_HZ


def _stage(
    bench: Bench, current: Fit, heights: Mapping[str, float], tell: Callable[[str], None]
) -> Stage:
    moved, known, plain = motion_of(bench, current)
    plain = with_slack(known, plain)
    scene = Scene(known, plain, tuple(moved), heights)
    where = locate(scene)
    if current.hypothesis.found and _explained(current, where, bench):
        return Stage(current, where, (), ())
    candidates = screen(scene, without=current.hypothesis.labels)
    fits = []
    for candidate in _promising(candidates):
        tell(f"fitting {candidate.label[0]} at {candidate.label[1]}")
        found = _fitted(bench, current, candidate)
        if found is not None:
            fits.append(found)
    fits.sort(key=lambda f: f.bic)
    if fits:
        # in a tie the simplest is named first, a changed part before missing physics
        tied = [f for f in fits if f.bic < fits[0].bic + TIE]
        first = min(tied, key=lambda f: (f.free, f.hypothesis.found[-1].verdict != "parameter"))
        fits.remove(first)
        fits.insert(0, first)
    return Stage(current, where, tuple(candidates), tuple(fits))


def _explained(current: Fit, where: Mapping[str, float], bench: Bench) -> bool:
    """Return whether neither the filter nor a latent force anywhere finds anything left."""
    return current.slack <= LITTLE and max(where.values()) < FURTHER_SAMPLE * bench.samples / 2


def _promising(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the candidates that are worth fitting in full, the most promising first."""
    worth = [c for c in candidates if c.gain > DECISIVE / 4]
    random = [c for c in worth if isinstance(c.mechanism, Disturbance)][:1]
    others = [c for c in worth if not isinstance(c.mechanism, Disturbance)][:REFINED]
    others = [c for c in others if c.gain > WORTH * others[0].gain]
    return others + random


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
    except np.linalg.LinAlgError:
        return None
