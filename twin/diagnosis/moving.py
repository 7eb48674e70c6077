"""The same mechanism elsewhere, and what was nearly as likely when one was chosen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import added, attempted, by_name, carried, likelier, moved_to
from twin.diagnosis.candidates import Candidate
from twin.diagnosis.dropping import on_part, settled_against
from twin.diagnosis.explanation import Explanation, explained
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.portion import ROUGH, SURE, beginning_of
from twin.estimation.fit import Fit
from twin.mechanisms.mechanism import ChannelFault

Array = NDArray[np.float64]
Label = tuple[str, str]


@dataclass(frozen=True)
class Rival:
    """An explanation that another one was preferred to.

    Attributes:
        chosen: name and place of the last mechanism of that other one.
        explanation: whose last mechanism is another one, and the rest the same.
    """

    chosen: Label
    explanation: Explanation


def rivals_of(best: Explanation, fits: Sequence[Explanation]) -> list[Rival]:
    """Return the explanations that are behind by less than what settles anything.

    Args:
        best: that was chosen among them.
        fits: explanations with one mechanism each beyond the same others, or several.
    """
    common = best.labels[:-1]
    return [
        Rival(best.labels[-1], e)
        for e in fits
        if e.labels[:-1] == common and e.labels[-1] != best.labels[-1]
        and e.log_odds > best.log_odds - SURE
    ]  # fmt: skip


def in_their_place(best: Explanation, rivals: Sequence[Rival], cost: float) -> list[Explanation]:
    """Return the explanation with each rival instead of what was chosen, fitted.

    What is alike to all sensors would else be told apart by what was found later, beside one of the
    two alone.

    Args:
        best: the explanation.
        rivals: of its mechanisms; those of what is not there any more are passed over.
        cost: of each mechanism [nat].
    """
    there = [r for r in rivals if len(best.labels) > 1 and r.chosen in best.labels
             and r.explanation.labels[-1] not in best.labels]  # fmt: skip
    beside = on_part(best) if there else None
    tried = (
        _instead(best, best.labels.index(r.chosen), r.explanation, cost, beside) for r in there
    )
    return [found for found in tried if found is not None]


def elsewhere(best: Explanation, candidates: Sequence[Candidate], cost: float) -> list[Explanation]:
    """Return the explanation with its last mechanism at other places, where it may be as likely.

    A place says how probable it is only beside every other one; where few modes tell places apart,
    those that the screening puts behind may be ahead once they are fitted.

    Args:
        best: the explanation.
        candidates: what may be; none but the same mechanism at other places is tried, and of what
            is a channel's none.
        cost: of each mechanism [nat].
    """
    h, z = best.hypothesis, best.fit.z
    (*_, found), (*_, (name, place)) = h.at(z), best.labels
    others = [c for c in candidates if c.label[0] == name and c.label[1] != place]
    if not others or isinstance(found, ChannelFault):
        return []
    rest = replace(h, mechanisms=h.mechanisms[:-1], priors=h.priors[:-1])
    part = attempted(beginning_of(h), z, enough=ROUGH)
    least = -np.inf if part is None else part.log_evidence - SURE
    out = []
    for candidate in others:
        there = replace(found, place=candidate.label[1])
        grown = added(rest, candidate, there)
        starts = (there, there.scaled(_as_much(h, place, there.place)))
        short = beginning_of(grown)
        _, begun = likelier(short, [moved_to(grown, h, z, start) for start in starts])
        near = attempted(short, begun, hopeless=least, enough=ROUGH)
        if near is None or near.log_evidence < least:
            continue
        moved = explained(grown, near.z, cost, best)
        if moved is not None:
            out.append(moved)
    return out


def _as_much(h: Hypothesis, place: str, other: str) -> float:
    """Return how many times as strong a pull elsewhere does as much, by the square of the motion.

    Only the scales of ports are known; what has no port is left as strong.
    """
    ports = h.problem.model.ports
    if h.scales is None or not {place, other} <= set(ports):
        return 1.0
    return (h.scales.at(place)[1] / h.scales.at(other)[1]) ** 2


def _instead(
    best: Explanation, at: int, other: Explanation, cost: float, beside: Fit | None
) -> Explanation | None:
    """Return an explanation with the last mechanism of another one at a place of the list.

    None where a part of the samples, to which the explanation was fitted, settles that it is less
    likely.
    """
    h = best.hypothesis
    mechanisms, priors = list(h.mechanisms), list(h.priors)
    mechanisms[at], priors[at] = other.hypothesis.mechanisms[-1], other.hypothesis.priors[-1]
    exchanged = replace(h, mechanisms=tuple(mechanisms), priors=tuple(priors))
    ours, theirs = (by_name(e.hypothesis, e.fit.z) for e in (best, other))
    begun = [carried(exchanged, known) for known in (theirs | ours, ours | theirs)]
    if beside is not None and settled_against(exchanged, begun, beside):
        return None
    _, z = likelier(exchanged, begun)
    return explained(exchanged, z, cost, best)
