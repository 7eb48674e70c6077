"""What was promising, fitted: on a part of the samples first, then on all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.as_drawn import Begun
from twin.diagnosis.beginning import (
    added,
    attempted,
    beginnings,
    from_nominal,
    likelier,
    likeliest,
    moved_to,
)
from twin.diagnosis.between import again
from twin.diagnosis.drawing import far_off
from twin.diagnosis.explanation import Explanation, converged, explained
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.portion import ROUGH, SURE, beginning_of, on_a_part
from twin.diagnosis.trifles import is_trifle
from twin.diagnosis.valleys import Score
from twin.estimation.fit import Fit

Array = NDArray[np.float64]
Compared = dict[int, tuple[Hypothesis, Fit | None]]


def fitted(
    here: Hypothesis, before: Explanation, begun: Sequence[Begun], cost: float,
    tell: Callable[[str], None],
) -> list[Explanation]:  # fmt: skip
    """Return the explanations with what was promising, fitted, the likeliest first.

    A part of the samples says which ones need not be tried, and where the others may begin. What is
    a trifle there is tried where something else is found that may be likely for want of it: all
    samples would make it certain, not greater.

    Args:
        here: the hypothesis that they grow from.
        before: its explanation.
        begun: what was promising.
        cost: of each mechanism [nat].
        tell: is told each fit.
    """
    compared: Compared = {index: (one.hypothesis, None) for index, one in enumerate(begun)}
    trifles: list[int] = []
    if on_a_part(here) is not None:
        tell(f"comparing {len(begun)} candidates")
        compared = _compared(begun)
        if before.labels:
            trifles = [i for i, (h, end) in compared.items() if end and is_trifle(h, end)]
    fits: list[Explanation] = []
    for number, index in enumerate([*(i for i in compared if i not in trifles), *trifles]):
        if index in trifles and all(e.log_odds <= before.log_odds for e in fits):
            break
        h, end = compared[index]
        z = begun[index].z if end is None else end.z
        new = h.mechanisms[len(here.mechanisms) :]
        place = f"{len(new)} channels" if len(new) > 1 else new[0].place
        tell(f"fitting {new[0].name} at {place} ({number + 1} of {len(compared)})")
        top = max(fits, key=lambda e: e.log_odds, default=before)
        found = explained(h, likelier(h, [begun[index].z, z])[1], cost, top)
        if found is not None:
            fits.append(found)
    most = max((e.log_odds for e in fits), default=0.0)
    near = [e.log_odds > most - 2 * SURE for e in fits]  # what their own ends would tell apart
    if sum(near) > 1:
        fits = [converged(e) if close else e for e, close in zip(fits, near, strict=True)]
    return sorted(fits, key=lambda e: -e.log_odds)


def _compared(begun: Sequence[Begun]) -> Compared:
    """Return which hypotheses to fit, and how they came out beside a part of the samples, by index.

    The likeliest first, and not those that are behind another one both there and in the screening
    of all samples, nor those that ran away behind any. Each with the inputs between samples that
    are likeliest with it: a twin that lacks it may have taken them for something else.
    """
    found: dict[int, tuple[float, Hypothesis, Fit | None]] = {}
    for index, one in enumerate(begun):
        h, z = one.hypothesis, one.z
        ahead = max((found[i][0] for i in found if begun[i].gain >= one.gain), default=-np.inf)
        most = max((value for value, _, _ in found.values()), default=-np.inf)
        starts = [z, from_nominal(h, z)] if far_off(h.problem, z) else [z]
        told: list[tuple[float, Hypothesis, Fit | None]] = [(-np.inf, h, None)]
        part = beginning_of(h)
        for at in starts:
            end = attempted(part, at, hopeless=ahead - SURE, enough=ROUGH)
            if end is None:
                continue
            other = part
            if end.code != "ran away" or end.log_evidence > most - SURE:
                other, end = again(part, end, steps=0, enough=ROUGH, inputs_alone=True)
            whole = replace(h, problem=replace(h.problem, between=other.problem.between))
            told.append((end.log_evidence, h if other is part else whole, end))
        found[index] = max(told, key=lambda one: one[0])
    most = max((value for value, _, _ in found.values()), default=-np.inf)
    out: Compared = {}
    for index, (value, h, end) in sorted(found.items(), key=lambda item: -item[1][0]):
        lost = end is not None and end.code == "ran away"
        ahead = max(found[i][0] for i in found if begun[i].gain >= begun[index].gain)
        if value >= (most if lost else ahead) - SURE:
            out[index] = h, end
    return out


def grown_by(here: Hypothesis, before: Explanation, scores: Sequence[Score]) -> Begun:
    """Return the hypothesis with what was screened, and where its fit begins."""
    grown, z, shift = here, before.fit.z, dict[str, float]()
    for score in scores:
        more = added(grown, score.candidate, score.start)
        grown, z = more, moved_to(more, grown, z, score.start)
        shift |= score.shift if len(scores) == 1 else {}
    moved = z + np.array([shift.get(u.name, 0.0) for u in grown.unknowns])
    _, z = likeliest(on_a_part(grown) or grown, [z, *beginnings(grown, moved)])
    return Begun(grown, z, sum(score.gain for score in scores))
