"""How sure one may be: odds between hypotheses from how evenly the recordings favour one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from twin.diagnosis.fitting import Fit, covariances

Array = NDArray[np.float64]

WINDOW = 256
"""Samples in a window whose log likelihood counts as one observation."""


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
    """Return the probability that ``best`` predicts better than ``other`` on further windows.

    The difference of the two log likelihoods, window by window, is a sample whose sum has a
    standard error (Vehtari, Gelman and Gabry 2017); the BIC's penalty for parameters is part of
    the sum. A likelihood ratio alone would be sure of anything in so many samples.
    """
    difference = windows(best) - windows(other)
    penalty = 0.5 * (best.free - other.free) * np.log(best.samples)
    prior = best.log_prior - other.log_prior
    total = float(np.sum(difference)) - penalty + prior
    error = float(np.sqrt(len(difference)) * np.std(difference, ddof=1))
    # two explanations within a few nats are a tie whatever their windows say
    return float(stats.norm.cdf(total / np.hypot(error, 3.0)))


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
