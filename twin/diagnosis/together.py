"""What is tried at once: faults of one kind, and masses and stiffnesses off the drawing alone.

A drawing may err everywhere, or in a few places alone: with a wide tolerance for all, what is off
alone is no finding, and with a narrow one what errs everywhere is many. Both are fitted.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import added, moved_to
from twin.diagnosis.candidates import Candidate
from twin.diagnosis.drawing import standing_out, with_tolerance
from twin.diagnosis.explanation import Explanation, explained
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.valleys import Score
from twin.mechanisms.mechanism import ChannelFault

Array = NDArray[np.float64]

FAMILIES = 2
"""Faults that are tried in all channels at once in a search step: each is a fit, and a third one
would be the least promising."""


def families(here: Hypothesis, scores: Sequence[Score], cost: float) -> list[list[Score]]:
    """Return faults that several channels have at once, as mains hum or a warm amplifier's drift.

    One by one they may lose to a force, which moves all channels.
    """
    kinds = dict[str, list[Score]]()
    for score in scores:
        start = score.start
        linear = isinstance(start, ChannelFault) and start.instrument(1.0) is not None
        if linear and start.place in here.problem.model.outputs and score.gain > cost:
            kinds.setdefault(start.name, []).append(score)
    several = [family for family in kinds.values() if len(family) > 1]
    return sorted(several, key=lambda family: -sum(s.gain for s in family))[:FAMILIES]


def off_alone(
    here: Hypothesis, best: Explanation, candidates: Sequence[Candidate], cost: float
) -> list[Explanation]:
    """Return an explanation with what stands out of the drawing, at the tolerance of the rest.

    Args:
        here: the hypothesis that the explanation has, with the scales of candidates.
        best: the explanation.
        candidates: what may be.
        cost: of each mechanism [nat].
    """
    tolerance, out = standing_out(best.hypothesis, best.fit)
    labels = {f"{name} {place}": c for c in candidates for name, place in [c.label]}
    names = [here.unknowns[i].name for i in out]
    if not names or not set(names) <= set(labels):
        return []
    grown, z = with_tolerance(here, best.fit.z, tolerance)
    for index, name in zip(out, names, strict=True):
        unknown, candidate = grown.unknowns[index], labels[name]
        (start, *_), (parameter,) = candidate.starts, candidate.starts[0].parameters
        change = unknown.value(float(z[index])) - unknown.value(0.0)
        start = start.with_values({parameter: change})
        z[index] = 0.0
        more = added(grown, candidate, start)
        grown, z = more, moved_to(more, grown, z, start)
    found = explained(grown, z, cost, best)
    return [] if found is None else [found]
