"""The search over sets of mechanisms: add, drop, exchange, by evidence alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import added, beginnings, likeliest, moved_to, start_of
from twin.diagnosis.between import again
from twin.diagnosis.candidates import Candidate, motions, scales_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.non_parametric import doubtful, in_place_of
from twin.diagnosis.predict import stages
from twin.diagnosis.problem import Motion, Problem
from twin.diagnosis.screening import screen
from twin.diagnosis.sizes import forces, inexact, known_forces, of_known
from twin.diagnosis.valleys import Score
from twin.estimation.fit import Fit, fit
from twin.estimation.likelihood import evaluate
from twin.estimation.passing import Run
from twin.mechanisms.mechanism import ChannelFault

Array = NDArray[np.float64]

WIDTH = 6
"""Candidates of the screening that are fitted in a search step."""

FAMILIES = 2
"""Faults that are tried in all channels at once in a search step: each is a fit, and a third one
would be the least promising."""

MOST = 4
"""Mechanisms at most."""


@dataclass(frozen=True)
class Explanation:
    """A fitted set of mechanisms.

    Attributes:
        hypothesis, fit: what was fitted, and how it came out.
        log_odds: log evidence less what the set costs beforehand: every mechanism at every place
            is as likely as any other, and any at all as likely as none.
    """

    hypothesis: Hypothesis
    fit: Fit
    log_odds: float

    @property
    def labels(self) -> tuple[tuple[str, str], ...]:
        """Name and place of each mechanism."""
        return tuple((m.name, m.place) for m in self.hypothesis.mechanisms)


@dataclass(frozen=True)
class Found:
    """What the search found.

    Attributes:
        nothing: the calibrated twin without further mechanisms.
        best: the explanation with the greatest odds.
        others: every other explanation that was fitted, best first.
        screened: the screening of each step.
        motion: the motion of every recording by the best explanation.
    """

    nothing: Explanation
    best: Explanation
    others: tuple[Explanation, ...]
    screened: tuple[tuple[Score, ...], ...]
    motion: tuple[Motion, ...]


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
    nothing = Explanation(empty, calibrated, calibrated.log_evidence)
    best = nothing
    tried: dict[tuple[tuple[str, str], ...], Explanation] = {(): nothing}
    screened = []
    moved = motions(problem, empty, calibrated.z)
    for step in range(MOST):
        tell(f"search step {step + 1}: screening")
        here = replace(best.hypothesis, scales=scales_of(problem, moved))
        runs = evaluate(best.hypothesis, best.fit.z, derivatives=False).runs
        candidates = [c for c in offer(moved, runs) if c.label not in best.labels]
        cost = float(np.log(max(len(candidates), 2)))
        scores = screen(best.fit, here, candidates, moved)
        screened.append(tuple(scores))
        promising = [s for s in scores if s.gain > cost][:WIDTH]
        fits: list[Explanation] = []
        for number, score in enumerate(promising):
            what = " at ".join(score.candidate.label)
            tell(f"search step {step + 1}: fitting {what} ({number + 1} of {len(promising)})")
            top = max((e.log_odds for e in fits), default=best.log_odds)
            explained = _fitted(here, best, [score], cost, top)
            if explained is not None:
                fits.append(explained)
                key = tuple(sorted(explained.labels))
                if key not in tried or tried[key].log_odds < explained.log_odds:
                    tried[key] = explained
        for family in _families(here, scores, cost):
            tell(f"search step {step + 1}: fitting {family[0].candidate.label[0]} of "
                 f"{len(family)} channels")  # fmt: skip
            top = max((e.log_odds for e in fits), default=best.log_odds)
            explained = _fitted(here, best, family, cost, top)
            if explained is not None:
                fits.append(explained)
                tried.setdefault(tuple(sorted(explained.labels)), explained)
        fits.sort(key=lambda e: -e.log_odds)
        if not fits or fits[0].log_odds <= best.log_odds:
            break
        better = [e for e in fits if e.log_odds > best.log_odds]
        # what is a trifle beside the others may stand in for what is none
        best = next((e for e in better if not _ends_in_a_trifle(e)), better[0])
        best = _from_prior_noise(best)
        best = _without_needless(best, cost, tried)
        hypothesis, found = again(best.hypothesis, best.fit)
        gained = found.log_evidence - best.fit.log_evidence
        best = Explanation(hypothesis, found, best.log_odds + gained)
        if _ends_in_a_trifle(best):
            break
        moved = motions(problem, best.hypothesis, best.fit.z)
    unnamed = _without_names(best, offer, moved, tried, tell)
    if unnamed.labels != best.labels:
        best = unnamed
        moved = motions(problem, best.hypothesis, best.fit.z)
    others = sorted((e for e in tried.values() if e.labels != best.labels),
                    key=lambda e: -e.log_odds)  # fmt: skip
    return Found(nothing, best, tuple(others), tuple(screened), moved)


def _without_names(
    best: Explanation,
    offer: Offer,
    moved: Sequence[Motion],
    tried: dict[tuple[tuple[str, str], ...], Explanation],
    tell: Callable[[str], None],
) -> Explanation:
    """Return the explanation with a non-parametric force for names that mimic it, if likelier."""
    h, z = best.hypothesis, best.fit.z
    if not h.mechanisms:
        return best
    dubious = doubtful(h, best.fit, forces(h, z, stages(h, z)))
    if not dubious:
        return best
    candidates = offer(moved, evaluate(h, z, derivatives=False).runs)
    cost = float(np.log(max(len(candidates), 2)))
    for number, (other, starts) in enumerate(in_place_of(h, best.fit, moved, candidates, dubious)):
        place = other.mechanisms[-1].place
        tell(f"fitting a non-parametric restoring force at {place} ({number + 1})")
        _, begun, _ = likeliest(other, [z for start in starts for z in beginnings(other, start)])
        explained = _explained(other, begun, cost, best.log_odds)
        if explained is not None:
            explained = _without_needless(explained, cost, tried)
            tried.setdefault(tuple(sorted(explained.labels)), explained)
            best = max(best, explained, key=lambda e: e.log_odds)
    return best


def _from_prior_noise(best: Explanation) -> Explanation:
    """Return an explanation fitted again from the noise that the samples show, if that is likelier.

    The noise that a poorer twin needed may hold a better one back.
    """
    z, h = best.fit.z, best.hypothesis
    noisy = np.array([u.role == "noise" for u in h.unknowns])
    try:
        found = fit(h, np.where(noisy, 0.0, z))
    except (ValueError, np.linalg.LinAlgError):
        return best
    gained = found.log_evidence - best.fit.log_evidence
    return replace(best, fit=found, log_odds=best.log_odds + gained) if gained > 0 else best


def _ends_in_a_trifle(best: Explanation) -> bool:
    """Return whether the last mechanism found is smaller than the laws before it are inexact."""
    mechanisms, z = best.hypothesis.at(best.fit.z), best.fit.z
    if isinstance(mechanisms[-1], ChannelFault):
        return False  # a channel's calibration says nothing of the structure
    beside = stages(best.hypothesis, z)
    sizes = forces(best.hypothesis, z, beside)
    known = known_forces(best.hypothesis, z, beside)
    last = len(sizes) - 1
    left = inexact(mechanisms, sizes, last, known)
    left = max(left, of_known(best.hypothesis.problem, mechanisms[last], known))
    return 0.0 < (sizes[last] or 0.0) < left


def _families(here: Hypothesis, scores: Sequence[Score], cost: float) -> list[list[Score]]:
    """Return faults that several channels have at once, as mains hum or a warm amplifier's drift.

    One by one they may lose to a force, which moves all channels.
    """
    kinds = dict[str, list[Score]]()
    for score in scores:
        start = score.start
        linear = isinstance(start, ChannelFault) and start.instrument(1.0) is not None
        if linear and start.place in here.problem.model.outputs and score.gain > cost:
            kinds.setdefault(start.name, []).append(score)
    families = [family for family in kinds.values() if len(family) > 1]
    return sorted(families, key=lambda family: -sum(s.gain for s in family))[:FAMILIES]


def _fitted(
    here: Hypothesis, before: Explanation, scores: Sequence[Score], cost: float, top: float
) -> Explanation | None:
    grown, z, shift = here, before.fit.z, dict[str, float]()
    for score in scores:
        more = added(grown, score.candidate, score.start)
        grown, z = more, moved_to(more, grown, z, score.start)
        shift |= score.shift if len(scores) == 1 else {}
    moved = z + np.array([shift.get(u.name, 0.0) for u in grown.unknowns])
    _, z, _ = likeliest(grown, [z, *beginnings(grown, moved)])
    return _explained(grown, z, cost, top)


def _explained(h: Hypothesis, z: Array, cost: float, top: float) -> Explanation | None:
    """Return a set of mechanisms fitted from z, (p,), with what the inputs do between samples.

    A twin that lacks it may have taken them for something else.
    """
    spent = cost * len(h.mechanisms)
    try:
        h, found = again(h, fit(h, z, hopeless=top + spent), steps=0)
    except (ValueError, np.linalg.LinAlgError):
        return None
    if not np.isfinite(found.log_evidence):
        return None
    return Explanation(h, found, found.log_evidence - spent)


def _without_needless(
    best: Explanation, cost: float, tried: dict[tuple[tuple[str, str], ...], Explanation]
) -> Explanation:
    """Drop mechanisms that are not needed any more, the least needed first."""
    while len(best.hypothesis.mechanisms) > 1:
        options = []
        for index in range(len(best.hypothesis.mechanisms) - 1):
            fewer = dropped(best, index, cost, tuple(tried.values()))
            if fewer is not None:
                tried.setdefault(tuple(sorted(fewer.labels)), fewer)
                options.append(fewer)
        options.sort(key=lambda e: -e.log_odds)
        if not options or options[0].log_odds <= best.log_odds:
            return best
        best = options[0]
    return best


def dropped(
    best: Explanation, index: int, cost: float, tried: Sequence[Explanation] = ()
) -> Explanation | None:
    """Return the explanation without one of its mechanisms, fitted again.

    One fit begins where the others are now or where they were without it, whichever is likelier.
    Others begin with a process noise so wide that what the mechanism had taken upon itself does not
    hold the rest back, from where that is and from the nominal twin.
    """
    h = best.hypothesis
    fewer = replace(
        h,
        mechanisms=(*h.mechanisms[:index], *h.mechanisms[index + 1 :]),
        priors=(*h.priors[:index], *h.priors[index + 1 :]),
    )
    known = {u.name: x for u, x in zip(h.unknowns, best.fit.z, strict=True)}
    kept = {(m.name, m.place) for m in fewer.mechanisms}
    options = [np.array([known[u.name] for u in fewer.unknowns])]
    for e in tried:
        if e.labels and set(e.labels) <= kept:
            then = dict(zip((u.name for u in e.hypothesis.unknowns), e.fit.z, strict=True))
            options.append(np.array([then.get(u.name, known[u.name]) for u in fewer.unknowns]))
    _, near, _ = likeliest(fewer, options)
    _, *wide = beginnings(fewer, options[0])
    fits = [_explained(fewer, z, cost, best.log_odds) for z in (near, *wide)]
    return max((e for e in fits if e is not None), key=lambda e: e.log_odds, default=None)
