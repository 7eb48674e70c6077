"""How sure one may be: odds between hypotheses from how evenly the recordings favour one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit
from scipy.stats import norm

from twin.diagnosis.fitting import Fit, covariances

Array = NDArray[np.float64]

WINDOW = 256
"""Samples in a window whose log likelihood counts as one observation."""

UNSURE = 1.0
"""Standard error of a BIC [nats]."""

ROUGH = 0.5
"""The same of its penalty for one parameter, as a share of it: for the shape of a weak law, which
recordings hardly tell, a penalty of half as much is nearer, for that of a strong one of more."""

LOGISTIC = 1.702
"""Standard deviation of the normal law whose distribution is nearest to the logistic function."""


def windows(fit: Fit) -> Array:
    """Return the log likelihood of every window of every trial, (windows,)."""
    out = []
    for e, S in zip(fit.innovations, covariances(fit.innovations), strict=True):
        whitened = np.linalg.solve(np.linalg.cholesky(S), e.T)
        each = -0.5 * np.sum(whitened**2, axis=0) - 0.5 * np.linalg.slogdet(S)[1]
        count = len(each) // WINDOW
        out.append(each[: count * WINDOW].reshape(count, WINDOW).sum(axis=1))
    return np.concatenate(out)


def probability_over(best: Fit, other: Fit) -> float:
    """Return the probability that ``best`` is right rather than ``other``, even odds beforehand.

    Were one of the two exact, the odds would be their likelihoods', each with its BIC's penalty.
    Where neither is, that is sure of anything in so many samples; but then the difference of the
    log likelihoods scatters more from window to window (Vuong 1989; Vehtari, Gelman and Gabry 2017)
    than noise makes it, by the sum of squares of the whitened difference of the two predictions.
    What it scatters beyond that makes its sum as uncertain, and so does the penalty.
    """
    difference = windows(best) - windows(other)
    more = best.free - other.free
    penalty = 0.5 * float(np.log(best.samples))
    prior = best.log_prior - other.log_prior
    total = float(np.sum(difference)) - more * penalty + prior
    scatter = len(difference) * float(np.var(difference, ddof=1))
    unsure = UNSURE**2 + abs(more) * (ROUGH * penalty) ** 2
    unsure += max(scatter - _by_noise(best, other), 0.0)
    far = abs(total)
    sure = min(float(expit(far)), float(norm.cdf(far / np.hypot(LOGISTIC, np.sqrt(unsure)))))
    return sure if total > 0 else 1.0 - sure


def _by_noise(best: Fit, other: Fit) -> float:
    """Return the variance of the difference of two log likelihoods where one of them is exact."""
    total = 0.0
    for e, its, S in zip(
        best.innovations, other.innovations, covariances(best.innovations), strict=True
    ):
        total += float(np.sum(np.linalg.solve(np.linalg.cholesky(S), (e - its).T) ** 2))
    return total


def probabilities(fits: Sequence[Fit]) -> list[float]:
    """Return the probability of every fit, the first being the best by its BIC.

    Odds against the best one multiply out of the pairwise comparisons.
    """
    if not fits:
        return []
    odds = [1.0]
    for other in fits[1:]:
        p = min(max(probability_over(fits[0], other), 1e-12), 1 - 1e-12)
        odds.append(min((1 - p) / p, 1.0))
    total = sum(odds)
    return [o / total for o in odds]
