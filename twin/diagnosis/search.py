"""The search over sets of mechanisms: add, drop, exchange, by evidence alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.as_drawn import as_drawn, beside_the_drawing
from twin.diagnosis.beginning import beginnings, likelier, start_of
from twin.diagnosis.between import again
from twin.diagnosis.candidates import Candidate, motions, scales_of
from twin.diagnosis.drawing import at_its_tolerance, far_off, odds_of
from twin.diagnosis.dropping import on_part, settled_against, without_needless
from twin.diagnosis.explanation import (
    Explanation,
    converged,
    explained,
    from_prior_noise,
    says_less,
    settled,
)
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.law_form import as_large_as_found, beside_their_laws, without_a_name
from twin.diagnosis.motion import Motion, begun_with
from twin.diagnosis.moving import Rival, elsewhere, in_their_place, rivals_of
from twin.diagnosis.non_parametric import doubtful, in_place_of, named_for
from twin.diagnosis.portion import SURE
from twin.diagnosis.predict import predictors
from twin.diagnosis.problem import Problem
from twin.diagnosis.promising import fitted, grown_by
from twin.diagnosis.screening import screen
from twin.diagnosis.sizes import forces
from twin.diagnosis.together import families, off_alone
from twin.diagnosis.trifles import ends_in_a_trifle, no_trifle
from twin.diagnosis.valleys import WIDTH, Score, first_of_each
from twin.estimation.fit import fit
from twin.estimation.likelihood import passes
from twin.estimation.passing import Run
from twin.mechanisms.mechanism import Law

Array = NDArray[np.float64]

MOST = 4
"""Mechanisms at most."""


@dataclass(frozen=True)
class Found:
    """What the search found.

    Attributes:
        nothing: the calibrated twin without further mechanisms.
        best: the explanation with the greatest odds.
        others: every other explanation that was fitted, best first.
        screened: the screening of each step.
        motion: the motion of every recording by the best explanation.
        stated: NRMSE that recordings that were not seen will have, where it is stated.
    """

    nothing: Explanation
    best: Explanation
    others: tuple[Explanation, ...]
    screened: tuple[tuple[Score, ...], ...]
    motion: tuple[Motion, ...]
    stated: float | None = None


Tried = dict[tuple[tuple[str, str], ...], Explanation]
Offer = Callable[[Sequence[Motion], Sequence[Run]], Sequence[Candidate]]


def search(
    problem: Problem,
    offer: Offer,
    tell: Callable[[str], None] = lambda message: None,
    start: Array | None = None,
) -> Found:
    """Find the set of mechanisms with the greatest odds.

    Args:
        problem: the estimation problem.
        offer: returns all candidates, given motion and innovations of each recording.
        tell: is told each step.
        start: where the calibration begins, in prior deviations, (p,).
    """
    empty = Hypothesis(problem)
    calibrated = fit(empty, start_of(empty) if start is None else start)
    empty, calibrated = at_its_tolerance(empty, calibrated)
    nothing = Explanation(empty, calibrated, odds_of(empty, calibrated))
    tolerance, problem, best = problem.tolerance, empty.problem, nothing
    tried: Tried = {(): nothing}
    screened = []
    moved = motions(problem, empty, calibrated.z, calibrated.averages)
    # priors that stay what they are, so that evidences of all steps compare
    scales = scales_of(problem, moved)
    unnamed: Explanation | None = None
    rivals: list[Rival] = []
    step = 0
    while len(best.labels) < MOST:
        step += 1
        tell(f"search step {step}: screening")
        runs = passes(best.hypothesis, best.fit.z, best.fit.averages)
        here = replace(best.hypothesis, scales=scales, begun=tuple(map(begun_with, runs)))
        candidates = [c for c in offer(moved, runs) if not _included(c, best.hypothesis)]
        cost = float(np.log(max(len(candidates), 2)))
        say = partial(_say, tell, step)
        fits, scores = _promising(best, here, candidates, moved, cost, tolerance, say)
        before = best
        fits += off_alone(here, best, candidates, cost)
        fits.sort(key=lambda e: -e.log_odds)
        for explanation in fits:
            _keep(tried, explanation)
        better = [e for e in fits if e.log_odds > best.log_odds]
        trifling = False
        if better:
            best = from_prior_noise(no_trifle(better, cost))
            there = elsewhere(best, [s.candidate for s in scores if s.gain > cost], cost)
            for explanation in there:
                _keep(tried, explanation)
            fits += there
            best = max([best, *there], key=lambda e: e.log_odds)
            rivals += rivals_of(best, fits)
            if len(best.labels) > 1:
                best = without_needless(converged(best), cost, tried)
            hypothesis, found = at_its_tolerance(*again(best.hypothesis, best.fit))
            gained = odds_of(hypothesis, found) - odds_of(best.hypothesis, best.fit)
            turned = hypothesis.problem.between != best.hypothesis.problem.between
            best = Explanation(hypothesis, found, best.log_odds + gained)
            _keep(tried, best)
            if turned:  # what was found may have stood for other inputs between the samples
                best = without_needless(best, cost, tried)
            trifling = ends_in_a_trifle(best)
        screened.append(_by_fits(scores, before, fits))
        # one more name may do what the names so far do not: a force without one waits for it
        if unnamed is not None and unnamed.log_odds > best.log_odds:
            best, unnamed, trifling = unnamed, None, False
        elif not better:
            break
        else:
            moved = _moved(best)
            other = _without_names(best, candidates, cost, moved, tried, tell)
            if without_a_name(other.hypothesis):
                unnamed = other if other.labels != best.labels else None
            else:
                best = other
        if trifling and unnamed is None:
            break
        moved = _moved(best)
    if unnamed is not None and unnamed.log_odds > best.log_odds:
        best = unnamed
    best = settled(best, tried)
    moved = _moved(best)
    if rivals and len(best.labels) > 1:
        tell("fitting what was nearly as likely")
    for explanation in in_their_place(best, rivals, cost):
        _keep(tried, explanation)
        if explanation.log_odds > best.log_odds:
            best = explanation
            moved = _moved(best)
    others = sorted((e for e in tried.values() if e.labels != best.labels),
                    key=lambda e: -e.log_odds)  # fmt: skip
    return Found(nothing, best, tuple(others), tuple(screened), moved)


def _moved(best: Explanation) -> tuple[Motion, ...]:
    """Return the motion of every recording by an explanation."""
    h, fit = best.hypothesis, best.fit
    return motions(h.problem, h, fit.z, fit.averages)


def _by_fits(
    scores: Sequence[Score], before: Explanation, fits: Sequence[Explanation]
) -> tuple[Score, ...]:
    """Return the screening of a step, the greatest gains first: of what was fitted, the fit's."""
    gained = {e.labels[-1]: max(e.log_odds - before.log_odds, 0.0) for e in fits
              if e.labels[:-1] == before.labels}  # fmt: skip
    told = [replace(s, gain=gained.get(s.candidate.label, s.gain)) for s in scores]
    return tuple(sorted(told, key=lambda score: -score.gain))


def _say(tell: Callable[[str], None], step: int, what: str) -> None:
    tell(f"search step {step}: {what}")


def _promising(
    best: Explanation, here: Hypothesis, candidates: Sequence[Candidate], moved: Sequence[Motion],
    cost: float, tolerance: float, say: Callable[[str], None],
) -> tuple[list[Explanation], list[Score]]:  # fmt: skip
    """Return what was promising, fitted, and what slopes and short fits, or the drawing, promised.

    From far off its drawing a twin tells little of what it lacks: the drawing is asked first, and
    where what it says brings the twin back there, slopes wait for the next step, near the drawing.

    Args:
        best: the present explanation.
        here: its hypothesis, with the scales of the motion.
        candidates: what may be added.
        moved: the motion of each recording.
        cost: of each mechanism [nat].
        tolerance: of the drawing, as the search began with it.
        say: is told each fit.
    """
    # a force without a name waits for what names do, beside the drawing as well
    named = [c for c in candidates if not (c.starts[0].generic and isinstance(c.starts[0], Law))]
    drawn = as_drawn(here, best.fit.z, named, tolerance)
    first = first_of_each([s.candidate.label[0] for s in drawn])[:WIDTH]
    begun = [beside_the_drawing(here, drawn[i], tolerance) for i in first]
    fits = [e for e in fitted(here, best, begun, cost, say) if not says_less(e, candidates)]
    # a part off its drawing, beside which the others are as far off theirs, is no finding
    fits = [e for e in fits if _near(e) or e.hypothesis.mechanisms[-1].verdict != "parameter"]
    if any(e.log_odds > best.log_odds + SURE and _near(e) for e in fits):
        return fits, drawn
    told = screen(best.fit, here, candidates, moved)

    def more(scores: Sequence[Score]) -> list[Explanation]:
        worth = [s for s in scores if s.gain > cost]
        first = first_of_each([s.candidate.label[0] for s in worth])[:WIDTH]
        moves = [[worth[i]] for i in first] + families(here, scores, cost)
        begun = [grown_by(here, best, several) for several in moves]
        found = fitted(here, best, begun, cost, say)
        return [e for e in found if not says_less(e, candidates)]

    asked = told.valleys if told.by_chance else (*told.valleys, *told.hidden)
    scores = told.followed(*asked)
    fits += more(scores)
    if told.by_chance and any(e.log_odds > best.log_odds for e in fits):  # it was none
        asked_for = {s.candidate.label for s in scores if s.gain > cost}
        scores = told.followed(*told.hidden, more=scores)
        fits += more([s for s in scores if s.candidate.label not in asked_for])
    return fits, scores


def _near(explanation: Explanation) -> bool:
    """Return whether masses and stiffnesses are as near their drawing as a drawing errs."""
    return not far_off(explanation.hypothesis.problem, explanation.fit.z)


def _included(candidate: Candidate, h: Hypothesis) -> bool:
    """Return whether a candidate is there already, or only another form of what is there."""
    there = {(m.name, m.place) for m in h.mechanisms}
    return candidate.label in there or any(law.includes(candidate.starts[0]) for law in h.laws)


def _keep(tried: Tried, explanation: Explanation) -> None:
    """Keep the best fit of each set of mechanisms."""
    key = tuple(sorted(explanation.labels))
    if key not in tried or tried[key].log_odds < explanation.log_odds:
        tried[key] = explanation


def _without_names(
    best: Explanation,
    candidates: Sequence[Candidate],
    cost: float,
    moved: Sequence[Motion],
    tried: Tried,
    tell: Callable[[str], None],
) -> Explanation:
    """Return the explanation with a non-parametric force for names that mimic it, if likelier."""
    h, z = best.hypothesis, best.fit.z
    sizes = forces(h, z, predictors(h, z, best.fit.averages))
    dubious = doubtful(h, best.fit, sizes)
    if not dubious:
        return best
    beside, chosen = on_part(best), best
    options = in_place_of(h, best.fit, moved, candidates, dubious)
    options += beside_their_laws(h, best.fit, moved, candidates, dubious, sizes)
    for number, (other, starts) in enumerate(options):
        place = other.mechanisms[-1].place
        tell(f"fitting a non-parametric restoring force at {place} ({number + 1})")
        _, begun = likelier(other, [z for start in starts for z in beginnings(other, start)])
        if beside is not None and settled_against(other, [begun], beside):
            continue
        found = explained(other, begun, cost, best)
        if found is not None:
            if not without_a_name(other):
                found = as_large_as_found(found)
            found = without_needless(found, cost, tried)
            _keep(tried, found)
            best = max(best, found, key=lambda e: e.log_odds)
    # a name may be likelier from where the force is than from its own first guesses
    new = []
    if best is not chosen and without_a_name(best.hypothesis):
        new = named_for(best.hypothesis, best.fit, _moved(best), candidates)
    for other, starts in new:
        found = explained(other, likelier(other, starts)[1], cost, best)
        if found is not None:
            _keep(tried, found)
            best = max(best, found, key=lambda e: e.log_odds)
    return best
