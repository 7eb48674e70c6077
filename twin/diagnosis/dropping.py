"""Mechanisms that are not needed any more, once what they stood for is there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import attempted, beginnings, by_name, carried, likelier, likeliest
from twin.diagnosis.between import FEW
from twin.diagnosis.explanation import Explanation, explained
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.portion import ROUGH, SURE, beginning_of, on_a_part
from twin.estimation.fit import Fit

Array = NDArray[np.float64]


def without_needless(
    best: Explanation, cost: float, tried: dict[tuple[tuple[str, str], ...], Explanation]
) -> Explanation:
    """Drop mechanisms that are not needed any more, the least needed first."""
    while len(best.hypothesis.mechanisms) > 1:
        options, with_all = [], on_part(best)
        for index in range(len(best.hypothesis.mechanisms) - 1):
            fewer = dropped(best, index, cost, tuple(tried.values()), with_all)
            if fewer is not None:
                tried.setdefault(tuple(sorted(fewer.labels)), fewer)
                options.append(fewer)
        options.sort(key=lambda e: -e.log_odds)
        if not options or options[0].log_odds <= best.log_odds:
            return best
        best = options[0]
    return best


def dropped(
    best: Explanation, index: int, cost: float, tried: Sequence[Explanation] = (),
    with_all: Fit | None = None,
) -> Explanation | None:  # fmt: skip
    """Return the explanation without one of its mechanisms, fitted again.

    None where none comes near, or a part of the samples settles that it is needed. One fit begins
    where the others are now or where they were without it, whichever is likelier. Others begin with
    a process noise so wide that what the mechanism had taken upon itself does not hold the rest
    back, from where that is and from the nominal twin.
    """
    h, fewer = best.hypothesis, _without(best.hypothesis, index)
    known = by_name(h, best.fit.z)
    kept = {(m.name, m.place) for m in fewer.mechanisms}
    options = [carried(fewer, known)]
    for e in tried:
        if e.labels and set(e.labels) <= kept:
            options.append(carried(fewer, known | by_name(e.hypothesis, e.fit.z)))
    # the likelihood of the larger of two nested models never falls behind with more samples, on
    # the average
    if with_all is not None:
        begun = _starts(beginning_of(fewer), options)
        if settled_against(fewer, begun, with_all):
            return None
    fits: list[Explanation] = []
    for z in _starts(fewer, options)[:3]:  # sharp ones follow from these: ``explained``
        top = max([best, *fits], key=lambda e: e.log_odds)
        found = explained(fewer, z, cost, top)
        fits += [found] if found is not None else []
    return max(fits, key=lambda e: e.log_odds, default=None)


def lost(best: Explanation, index: int) -> float:
    """Return the log evidence that is lost without one of the mechanisms, roughly.

    What a part of the samples loses, times the share that it is.
    """
    whole, fewer = (beginning_of(h) for h in (best.hypothesis, _without(best.hypothesis, index)))
    z = carried(fewer, by_name(whole, best.fit.z))
    with_it = attempted(whole, best.fit.z, FEW)
    without_it = attempted(fewer, likeliest(fewer, beginnings(fewer, z))[1], FEW)
    if with_it is None or without_it is None:
        return np.inf
    return (
        (with_it.log_evidence - without_it.log_evidence)
        * best.hypothesis.problem.samples
        / whole.problem.samples
    )


def _without(h: Hypothesis, index: int) -> Hypothesis:
    return replace(
        h,
        mechanisms=(*h.mechanisms[:index], *h.mechanisms[index + 1 :]),
        priors=(*h.priors[:index], *h.priors[index + 1 :]),
    )


def _starts(fewer: Hypothesis, options: Sequence[Array]) -> list[Array]:
    _, near = likelier(fewer, options)
    _, *wide = beginnings(fewer, options[0])
    return [near, *wide]


def on_part(best: Explanation) -> Fit | None:
    """Return an explanation fitted to a part of the samples, None where the part is no less."""
    part = on_a_part(best.hypothesis)
    return None if part is None else attempted(part, best.fit.z, enough=ROUGH)


def settled_against(other: Hypothesis, begun: Sequence[Array], beside: Fit) -> bool:
    """Return whether a part of the samples settles that a hypothesis is the less likely one.

    Args:
        other: the hypothesis.
        begun: where fits of it begin, (p,) each.
        beside: of the other one, to the part.
    """
    part, least = beginning_of(other), beside.log_evidence - SURE
    for z in begun:
        found = attempted(part, z, hopeless=least, enough=ROUGH)
        if found is not None and found.log_evidence > least:
            return False
    return True
