"""What is smaller than what the others leave, while the search goes on beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from twin.diagnosis.beginning import by_name, carried, likelier
from twin.diagnosis.explanation import Explanation, explained
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.predict import predictors
from twin.diagnosis.sizes import forces, lost_in_laws, negligible
from twin.estimation.fit import Fit
from twin.estimation.law_averages import LawAverages
from twin.mechanisms.mechanism import ChannelFault, Disturbance


def ends_in_a_trifle(best: Explanation) -> bool:
    """Return whether the last mechanism found is smaller than what is left beside the others."""
    return is_trifle(best.hypothesis, best.fit, best.fit.averages)


def is_trifle(
    hypothesis: Hypothesis, found: Fit, averages: Sequence[LawAverages] | None = None
) -> bool:
    """Return whether the last mechanism is smaller than what is left beside the others.

    A channel's calibration says nothing of the structure: a fault of an instrument is one where the
    channel reads more of what laws leave.

    Args:
        hypothesis: the twin with its mechanisms, beside all samples.
        found: how it came out, there or beside a part of the samples.
        averages: of its laws beside all samples, where they are known.
    """
    last = hypothesis.at(found.z)[-1]
    if isinstance(last, ChannelFault) and not (hypothesis.doubted or hypothesis.erring):
        return False  # no law leaves anything
    if any(isinstance(m, Disturbance) for m in hypothesis.mechanisms[:-1]):
        return False  # names that are not found yet may be in a force that nobody measured
    try:
        beside = predictors(hypothesis, found.z, averages)
    except np.linalg.LinAlgError:
        return False  # all samples have no likelihood where the part has one
    if isinstance(last, ChannelFault):
        return lost_in_laws(hypothesis, found, beside, last)
    return negligible(hypothesis, found, beside, forces(hypothesis, found.z, beside))[-1]


def no_trifle(better: Sequence[Explanation], cost: float) -> Explanation:
    """Return the likeliest, or of what is no trifle the next one that there is beside it.

    A trifle may stand in for more, and more may be likely for no other reason than that the trifle
    is missing.

    Args:
        better: explanations, the likeliest first.
        cost: of each mechanism [nat].
    """
    likeliest = better[0]
    if not ends_in_a_trifle(likeliest):
        return likeliest
    structural = (e for e in better if not isinstance(e.hypothesis.mechanisms[-1], ChannelFault))
    more = (e for e in structural if not ends_in_a_trifle(e))
    return next((e for e in more if _there_beside(likeliest, e, cost)), likeliest)


def _there_beside(likeliest: Explanation, other: Explanation, cost: float) -> bool:
    """Return whether the likeliest explanation is likelier with what another one has besides."""
    h, more = likeliest.hypothesis, other.hypothesis
    every = zip(more.mechanisms, more.priors, other.labels, strict=True)
    new = [(m, prior) for m, prior, label in every if label not in likeliest.labels]
    if not new:
        return False
    mechanisms, priors = zip(*new, strict=True)
    both = replace(h, mechanisms=(*h.mechanisms, *mechanisms), priors=(*h.priors, *priors))
    ours, theirs = (by_name(e.hypothesis, e.fit.z) for e in (likeliest, other))
    begun = [carried(both, known) for known in (theirs | ours, ours | theirs)]
    found = explained(both, likelier(both, begun)[1], cost, likeliest)
    return found is not None and found.log_odds > likeliest.log_odds
