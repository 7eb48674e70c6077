"""A fitted set of mechanisms, and how one is fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import as_sharp, attempted, likelier, likeliest
from twin.diagnosis.between import again
from twin.diagnosis.candidates import Candidate, motions
from twin.diagnosis.discrepancy import DISCREPANCY_SHARE
from twin.diagnosis.drawing import odds_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.missing_force import nonlinear_share
from twin.diagnosis.portion import ROUGH, SURE, on_a_part
from twin.diagnosis.problem import LINEAR_PHASE
from twin.estimation.fit import ENOUGH, Fit, fit
from twin.mechanisms.mechanism import Disturbance, Law, Mechanism, StructuralChange

Array = NDArray[np.float64]


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


def explained(h: Hypothesis, z: Array, cost: float, top: Explanation) -> Explanation | None:
    """Return a set of mechanisms fitted from z, (p,), with what the inputs do between samples.

    A twin that lacks it may have taken them for something else. Where it is ahead or behind by more
    than settles anything, the fit ends where it hardly climbs (``converged``).

    Args:
        h: the set.
        z: where the fit begins.
        cost: of each mechanism [nat].
        top: what must be within reach.
    """
    spent = cost * len(h.mechanisms)
    # another tolerance may be worth as much to this one
    least = top.log_odds + spent - (odds_of(top.hypothesis, top.fit) - top.fit.log_evidence)
    fits: list[Explanation] = []
    options = [seen for form in in_every_form(h) for seen in seen_otherwise(form)]
    for option, begun in within_reach(options, z):
        ahead = max([least, *(e.fit.log_evidence for e in fits)])
        try:
            rough = fit(option, begun, hopeless=ahead, patience=SURE)
            if rough.code == "ran away" and rough.log_evidence < ahead - SURE:
                continue  # it ended nowhere: nothing there tells of inputs and filters
            other, found = _unless_known(option, rough)
            if abs(found.log_evidence - least) < SURE:
                found = fit(other, found.z, near=found.averages)
        except np.linalg.LinAlgError:
            continue
        if np.isfinite(found.log_evidence):
            fits.append(Explanation(other, found, odds_of(other, found) - spent))
    return max(fits, key=lambda e: e.log_odds, default=None)


def converged(explanation: Explanation) -> Explanation:
    """Return an explanation with its fit at its end; as it is, where laws run away from there.

    What laws do on the average of the motion is found anew where a fit begins.
    """
    h, found = explanation.hypothesis, explanation.fit
    last = attempted(h, found.z, near=found.averages)
    if last is None:
        return explanation
    gained = odds_of(h, last) - odds_of(h, found)
    return replace(explanation, fit=last, log_odds=explanation.log_odds + gained)


def settled(
    best: Explanation, tried: dict[tuple[tuple[str, str], ...], Explanation]
) -> Explanation:
    """Return the likeliest of all that was fitted, with its fit at its end.

    A fit that went on from an explanation may be less likely than it was thought, and than what it
    was chosen before.

    Args:
        best: what was chosen last.
        tried: every explanation, by its labels in order; the fits that are ended are put there.
    """
    ended = set[tuple[tuple[str, str], ...]]()
    while (key := tuple(sorted(best.labels))) not in ended:
        ended.add(key)
        tried[key] = best = converged(best)
        best = max(best, *tried.values(), key=lambda e: e.log_odds)
    return best


def in_every_form(h: Hypothesis) -> list[Hypothesis]:
    """Return a hypothesis with its last mechanism in each form that it may have.

    A band with edges and an oscillator's are told apart by the fits, not by where they begin.
    """
    *before, last = h.mechanisms
    return [replace(h, mechanisms=(*before, form)) for form in last.forms()]


def seen_otherwise(h: Hypothesis) -> tuple[Hypothesis, ...]:
    """Return a hypothesis with its laws simulated, and with laws that follow the motion.

    Where a law jumps it matters: a simulation sees the analyser's filter, but does not repeat a
    motion that a force moves which nobody measured. Where forces have corners alone it is not
    asked, unless they stir modes above half the sampling rate: a filter shows them nearly as they
    are, and blows at stops let every error grow. What is added to a law that jumps and is no force
    leaves that as it was.
    """
    if not h.stirs or not isinstance(h.mechanisms[-1], Law | Disturbance):
        return (h,)
    filters = (h.problem.low_pass or LINEAR_PHASE, None)
    return tuple(replace(h, problem=replace(h.problem, low_pass=f)) for f in filters)


def analyser_known(h: Hypothesis) -> bool:
    """Return whether the analyser's filter was found with the mechanisms before the last one.

    There is one analyser. Once a law was found that shows its filter, or shows none, others are
    compared behind it.
    """
    guessed = h.problem.low_pass == LINEAR_PHASE
    return not guessed and replace(h, mechanisms=h.mechanisms[:-1]).stirs


def _unless_known(h: Hypothesis, found: Fit, enough: float = ENOUGH) -> tuple[Hypothesis, Fit]:
    """Return a fit with other inputs between samples or another filter, if likelier (``again``).

    As it is where the analyser is known: the search asks again with what it chooses.
    """
    return (h, found) if analyser_known(h) else again(h, found, steps=0, enough=enough)


def within_reach(options: Sequence[Hypothesis], z: Array) -> list[tuple[Hypothesis, Array]]:
    """Return hypotheses that a part of the samples does not rule out, and where fits begin, (p,).

    Of one none is ruled out. What ends with laws seen as another option has them speaks for that
    one. Others begin with the inputs and the filter that the part led to, and where its fit ended
    if that is likelier. Laws that follow the motion cost a tenth of simulated ones, which end where
    they cannot get as far.
    """
    parts = map(on_a_part, options) if len(options) > 1 else ()
    ends: dict[tuple[tuple[Mechanism, ...], bool], tuple[Hypothesis, Fit]] = {}
    for part in sorted((part for part in parts if part is not None), key=lambda h: h.simulated):
        most = max((found.log_evidence for _, found in ends.values()), default=-np.inf)
        found = attempted(part, _sharpest(part, z), hopeless=most - SURE, enough=ROUGH)
        if found is not None and (found.code != "stopped" or found.log_evidence > most - SURE):
            ended, found = _unless_known(part, found, ROUGH)
            known = ends.get(_kind(ended))
            if known is None or found.log_evidence > known[1].log_evidence:
                ends[_kind(ended)] = ended, found
    if not ends:
        return [(option, _sharpest(option, z)) for option in options]
    least = max(found.log_evidence for _, found in ends.values()) - SURE
    begun = []
    for option in options:
        end = ends.get(_kind(option))
        if end is not None and end[1].log_evidence >= least:
            problem = replace(end[0].problem, recordings=option.problem.recordings)
            h = replace(option, problem=problem)
            begun.append((h, likelier(h, [_sharpest(h, z), end[1].z])[1]))
    return begun


def _kind(h: Hypothesis) -> tuple[tuple[Mechanism, ...], bool]:
    """Return the form of the mechanisms, and whether laws are seen through a filter."""
    return h.mechanisms, h.problem.low_pass is not None


def _sharpest(h: Hypothesis, z: Array) -> Array:
    """Return values, or the same with laws as sharp as they are seen, if these are likelier."""
    sharp = as_sharp(h, z)
    return z if np.array_equal(sharp, z) else likeliest(h, [z, sharp])[1]


def from_prior_noise(best: Explanation) -> Explanation:
    """Return an explanation fitted again from the noise that the samples show, if that is likelier.

    The noise that a poorer twin needed, and what its laws were off by, may hold a better one back.
    """
    z, h = best.fit.z, best.hypothesis
    own = np.arange(len(z)) >= h.first_latent
    rest = [u.role in ("noise", "error") or (u.level and o)
            for u, o in zip(h.unknowns, own, strict=True)]  # fmt: skip
    found = attempted(h, np.where(rest, 0.0, z), hopeless=best.fit.log_evidence)
    if found is None:
        return best
    gained = odds_of(h, found) - odds_of(h, best.fit)
    return replace(best, fit=found, log_odds=best.log_odds + gained) if gained > 0 else best


def says_less(explanation: Explanation, candidates: Sequence[Candidate]) -> bool:
    """Return whether a law was added that does only what a change of the structure there does.

    In the motion there was its force is k d + c v but for a share to which no law's form is known:
    a spring that did not yield, friction that is wider than the motion is fast.
    """
    h, z = explanation.hypothesis, explanation.fit.z
    law = h.at(z)[-1]
    if not isinstance(law, Law):
        return False
    changes = any(isinstance(c.starts[0], StructuralChange) and c.label[1] == law.place
                  for c in candidates)  # fmt: skip
    moved = motions(h.problem, h, z, explanation.fit.averages) if changes else ()
    return changes and nonlinear_share(law, h.problem, moved) < DISCREPANCY_SHARE
