"""The form of a law that is nearly right: a smooth force of the same displacement beside it.

The discrepancy at a law's port is noise in time, and what a law leaves is a function of the
displacement, time after time: several names would mimic that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import attempted
from twin.diagnosis.candidates import Candidate
from twin.diagnosis.discrepancy import DISCREPANCY_DEVIATION, DISCREPANCY_SHARE
from twin.diagnosis.drawing import odds_of
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.motion import Motion
from twin.diagnosis.non_parametric import exchanged, missing_of, regressed, ridge, terms_of
from twin.diagnosis.scales import ROUNDING
from twin.estimation.fit import WORTH, Fit
from twin.mechanisms.mechanism import Law
from twin.mechanisms.restoring_force import BENT, RestoringForce

Array = NDArray[np.float64]

MOST = DISCREPANCY_SHARE * float(np.exp(DISCREPANCY_DEVIATION))
"""Share of a law's force at the largest displacement that a term of its form has beforehand at
most: as much as a discrepancy is within a deviation of its prior."""


def without_a_name(hypothesis: Hypothesis) -> bool:
    """Return whether a generic mechanism stands for one, and not for the form of a law there."""
    generic = (m for m in hypothesis.mechanisms if m.generic)
    return any(
        not isinstance(m, RestoringForce) or not any(m.includes(law) for law in hypothesis.laws
                                                     if law is not m)
        for m in generic
    )  # fmt: skip


def beside_their_laws(
    hypothesis: Hypothesis,
    fit: Fit,
    moved: Sequence[Motion],
    candidates: Sequence[Candidate],
    dubious: set[int],
    sizes: Sequence[float | None],
) -> list[tuple[Hypothesis, list[Array]]]:
    """Return hypotheses with a law's form corrected, instead of what else stands at its port.

    What a law that is nearly right leaves is a smooth function of the same displacement: a
    non-parametric force. See ``in_place_of``; the law is the greatest at its port.
    """
    mechanisms = hypothesis.at(fit.z)
    if any(isinstance(m, RestoringForce) for m in mechanisms):
        return []
    out = []
    known = [m for m in hypothesis.problem.known_at(fit.z) if isinstance(m, Law)]
    for candidate in (c for c in candidates if isinstance(c.starts[0], RestoringForce)):
        place = candidate.starts[0].place
        here = {i for i in dubious if mechanisms[i].place == place}
        laws = [i for i in here if isinstance(mechanisms[i], Law)]
        greatest = max(laws, key=lambda i: sizes[i] or 0.0, default=None)
        if greatest is None or len(here) < 2:
            continue
        law = mechanisms[greatest]
        if not isinstance(law, Law) or not law.elastic:
            continue
        gone = here - {greatest}
        kept = [m for i, m in enumerate(mechanisms) if i not in gone and isinstance(m, Law)]
        forces = missing_of(hypothesis, fit, moved, (*kept, *known))
        shrunk = _shrunk(hypothesis, candidate, moved, forces, law)
        start, _ = regressed(hypothesis, shrunk, moved, forces)
        out.append(exchanged(hypothesis, fit, gone, shrunk, start))
    return out


def as_large_as_found(explanation: Explanation) -> Explanation:
    """Return an explanation whose last law's terms are as large beforehand as they are found to be.

    Each has a size of its own, by which the evidence is greatest (MacKay 1992): what a law leaves
    is of few of the terms, and the others are none.
    """
    best = explanation
    gained = WORTH
    while gained >= WORTH:  # less, Laplace's method itself is off by
        h, found = best.hypothesis, best.fit
        *before, form = h.at(found.z)
        assert isinstance(form, RestoringForce)
        first = len(h.problem.base_unknowns) + sum(len(m.parameters) for m in before)
        terms = slice(first, first + len(form.parameters))
        law = next(m for m in before if isinstance(m, Law) and form.includes(m))
        sizes = np.sqrt(found.z[terms] ** 2 + np.diag(found.covariance)[terms])
        priors = _sized(h.priors[-1], sizes, form, law)
        other, z = replace(h, priors=(*h.priors[:-1], priors)), found.z.copy()
        z[terms] *= [h.priors[-1][name][1] / deviation for name, (_, deviation) in priors.items()]
        again = attempted(other, z, near=found.averages)
        if again is None or again.log_evidence <= found.log_evidence:
            break
        gained = odds_of(other, again) - odds_of(h, found)
        best = replace(best, hypothesis=other, fit=again, log_odds=best.log_odds + gained)
    return best


def _shrunk(
    hypothesis: Hypothesis, candidate: Candidate, moved: Sequence[Motion],
    forces: Sequence[Array], law: Law,
) -> Candidate:  # fmt: skip
    """Return a law's form with terms as large beforehand as the force says, whose sum it is."""
    form = candidate.starts[0]
    assert isinstance(form, RestoringForce)
    weights, variances = ridge(*terms_of(hypothesis, candidate, moved, forces))
    sizes = np.sqrt(weights**2 + variances)
    return replace(candidate, priors=_sized(candidate.priors, sizes, form, law))


def _sized(
    priors: Mapping[str, tuple[float, float]], sizes: Array, form: RestoringForce, law: Law
) -> dict[str, tuple[float, float]]:
    """Return priors with so many times the deviations, (terms,), none as large as the law.

    Powers of the displacement and of the rate have names: they are no form of another law.
    """
    ends, still = form.reach * np.array([-1.0, 1.0]), np.zeros(2)
    most = MOST * float(np.max(np.abs(law.force(ends, still, still, 0.0))))
    out = {}
    for (name, (mean, deviation)), size in zip(priors.items(), sizes.tolist(), strict=True):
        out[name] = mean, min(size * deviation, most if name in BENT else ROUNDING * most)
    return out
