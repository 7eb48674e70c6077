"""One round of the search: locate, screen, and fit the most promising candidates in full."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from twin.diagnosis.base import level, surroundings
from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit, fit, lenient_gains
from twin.diagnosis.heard import best_of_each, elsewhere
from twin.diagnosis.locating import locate
from twin.diagnosis.motion import motion_of
from twin.diagnosis.refining import refined, with_slack
from twin.diagnosis.scene import Candidate, Scene
from twin.diagnosis.screen import ranked, screen
from twin.mechanisms.mechanism import Disturbance, Law, Mechanism

DECISIVE = 14.0
"""Drop of the BIC that a mechanism must bring: odds of e^7, less the forty-odd pairs of mechanism
and place that were looked at. In rigs with nothing missing the best of them drops it by 4 or so."""

PROMISES = 6.0
"""Gain in log likelihood in the screening from which a candidate is fitted in full."""

TIE = 6.0
"""Difference of the BIC below which two explanations tie: odds of 20."""

FURTHER_SAMPLE = 0.01
"""What a further mechanism must bring besides: a drop of the BIC of this much a sample."""

REFINED = 4
"""Candidates that are fitted in full at each stage, at most, besides unmeasured forces."""

WORTH = 0.1
"""Candidates that promise less than this share of the best one's gain are not fitted in full."""

RIVAL = 0.5
"""Once one fit leaves nothing for its filter to follow, laws with a memory, which are slow, are
fitted only where they promise this share of what it promised; a second unmeasured force always."""

LITTLE = 1e-3
"""Slack up to which a filter trusts its model as it stands."""

NARROW_HZ = 0.5
"""An unmeasured force that is found beside something else must have a narrower band than this: a
broad one is only what the first finding's model leaves over."""

EXPECTED = 4.0
"""Squares of the innovations, over those that the filter expects, up to which they are as expected:
noise levels are known within a factor of two."""


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


def next_stage(
    bench: Bench, current: Fit, heights: Mapping[str, float], tell: Callable[[str], None]
) -> Stage:
    """Return what one more mechanism would explain on top of a fit.

    Raises:
        numpy.linalg.LinAlgError: no filter follows the motion of what was found.
    """
    moved, known, plain = motion_of(bench, current)
    if known is not bench:
        # what known forces leave of the base's own error would else count for every candidate
        plain = fit(known, plain.hypothesis, plain.slack, plain.starts, iterations=3)
    plain = with_slack(known, plain)
    scene = Scene(known, plain, tuple(moved), heights)
    where = locate(scene)
    if current.hypothesis.found and explained(current, where, bench):
        return Stage(current, where, (), ())
    candidates = screen(scene, without=current.hypothesis.labels)
    fits: list[Fit] = []
    enough = 0.0
    for candidate in _promising(candidates):
        slow = isinstance(candidate.mechanism, Law) and candidate.mechanism.memory
        if slow and candidate.gain < enough:
            continue
        tell(f"fitting {candidate.label[0]} at {candidate.label[1]}")
        found = fitted(bench, current, candidate)
        if found is not None:
            fits.append(found)
            if found.slack <= LITTLE < current.slack:
                enough = max(enough, RIVAL * candidate.gain)
    if not any(f.slack <= LITTLE and is_lawful(f) for f in fits):
        fits += _from_other_guesses(scene, bench, current, fits)
    leading = min(fits, key=lambda f: f.bic, default=None)
    if leading is not None and leading.bic < current.bic - DECISIVE:
        fits += elsewhere(bench, leading)
    fits = best_of_each(fits)
    if fits:
        # in a tie a changed part is named before missing physics
        tied = [f for f in fits if f.bic < fits[0].bic + TIE]
        first = min(tied, key=lambda f: f.hypothesis.found[-1].verdict != "parameter")
        fits.remove(first)
        fits.insert(0, first)
    return Stage(current, where, tuple(candidates), tuple(fits))


def _from_other_guesses(scene: Scene, bench: Bench, current: Fit, fits: Sequence[Fit]) -> list[Fit]:
    """Fit laws again that have several valleys, from the likeliest of their own first guesses.

    The screening scales them along a smoothed motion, which is far from the true one where a law
    is strong; as they stand the likelihood itself ranks them.
    """
    last = [f.hypothesis.found[-1] for f in fits]
    laws = [law for law in last if isinstance(law, Law) and law.valleys > 1]
    motion = scene.motion() if laws else {}
    out = []
    for first in laws:
        around = surroundings(scene.bench, motion, scene.heights, first.place)
        for _, start in ranked(scene, first.starts(first.place, around))[: first.valleys - 1]:
            found = fitted(bench, current, Candidate(start, 0.0))
            out += [found] if found is not None else []
    return out


def explained(current: Fit, where: Mapping[str, float], bench: Bench) -> bool:
    """Return whether neither the filter nor a latent force anywhere finds anything left.

    With friction a latent force does not tell: where that jumps, it is not known well enough to say
    what else there is. There the laws' own filter must find what it expects, too.
    """
    if has_friction(current) and not _expected(current, bench):
        return False
    return current.slack <= LITTLE and max(where.values()) < FURTHER_SAMPLE * bench.samples / 2


def has_friction(current: Fit) -> bool:
    """Return whether something that was found sticks and slips."""
    return current.hypothesis.sticks


def _expected(current: Fit, bench: Bench) -> bool:
    """Return whether the innovations that are compared are as small as the filter expects."""
    for trial, gains, e in zip(bench.trials, current.gains, current.innovations, strict=True):
        compared = e if trial.blurred is None else e[~trial.blurred]
        if np.any(np.mean(compared**2, axis=0) > EXPECTED * np.diag(gains.innovation)):
            return False
    return True


def _promising(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the candidates that are worth fitting in full, the most promising first."""
    worth = [c for c in candidates if c.gain > PROMISES]
    random = [c for c in worth if isinstance(c.mechanism, Disturbance)][:2]
    random = [c for c in random if c.gain > RIVAL * random[0].gain]
    others = [c for c in worth if not isinstance(c.mechanism, Disturbance)][:REFINED]
    others = [c for c in others if c.gain > WORTH * others[0].gain]
    return others + random


def fitted(bench: Bench, current: Fit, candidate: Candidate) -> Fit | None:
    """Fit a candidate on top of what was found, all parameters free.

    None where no filter follows it: neither on the way nor, with one that is, where it ends.
    """
    as_it_was = current.hypothesis
    starts = [as_it_was.including(candidate.mechanism)]
    if candidate.hypothesis is not None:
        # laws of earlier stages were known forces in the screening: keep their values
        along = replace(as_it_was, base=candidate.hypothesis.base)
        starts.append(along.including(candidate.mechanism))
    starts.append(level(as_it_was).including(candidate.mechanism))
    try:
        found = refined(bench, starts, current.slack, current.starts)
        lenient_gains(bench, found.hypothesis, found.slack)
    except np.linalg.LinAlgError:
        return None
    return found


def is_lawful(found: Fit) -> bool:
    """Return whether what was found last is no disturbance."""
    return not isinstance(found.hypothesis.found[-1], Disturbance)


def is_narrow(mechanism: Mechanism) -> bool:
    """Return whether a mechanism is no disturbance, or one in a narrow band."""
    return not isinstance(mechanism, Disturbance) or mechanism.oscillator()[1] < NARROW_HZ
