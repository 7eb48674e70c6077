"""The severity found in nine of ten cases, from cases that were found or not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import log_ndtr, ndtri

MIDDLE, MIDDLE_SPREAD = np.log(1.4), 1.0
"""Prior of the logarithm of the severity found in half of the cases, over the limit: normal."""

WIDTH, WIDTH_SPREAD = np.log(0.35), 0.6
"""Prior of the logarithm of the curve's width, normal: an ideal test's is 0.3 at the limit."""

SHARE = 0.9
INTERVAL = (0.025, 0.5, 0.975)


@dataclass(frozen=True)
class Found:
    """How well a group of cases was found.

    Attributes:
        found: of the cases.
        of: all its cases.
        ratio: severity found in nine of ten cases over the limit, the posterior's median.
        low: 2.5 % quantile of that.
        high: 97.5 % quantile.
    """

    found: int
    of: int
    ratio: float
    low: float
    high: float


def probit(cases: Mapping[str, Sequence[tuple[float, bool]]]) -> dict[str, Found]:
    """Fit a probit curve in the logarithm of the severity to every group, all of one width.

    The likelihood is that of the cases; the weak priors above keep a curve where all cases of a
    group, or none, were found. The posterior is summed on a grid of middles and widths.

    Args:
        cases: by group, (severity over its theoretical limit, whether it was found).
    """
    middles = np.linspace(-3.0, 4.0, 281)
    widths = np.linspace(np.log(0.03), np.log(3.0), 61)
    weight = {name: _posterior(np.array(of, float), middles, widths) for name, of in cases.items()}
    width = -0.5 * ((widths - WIDTH) / WIDTH_SPREAD) ** 2
    for density in weight.values():
        width = width + _log_sum(density)
    ninety = middles + ndtri(SHARE) * np.exp(widths)[:, None]
    out = {}
    for name, density in weight.items():
        joint = density - _log_sum(density)[:, None] + width[:, None]
        low, half, high = np.exp(_quantiles(ninety, np.exp(joint - joint.max())))
        hits = [found for _, found in cases[name]]
        out[name] = Found(sum(hits), len(hits), float(half), float(low), float(high))
    return out


def _posterior(cases: np.ndarray, middles: np.ndarray, widths: np.ndarray) -> np.ndarray:
    """Return the logarithm of likelihood times prior of the middle, (widths, middles)."""
    prior = -0.5 * ((middles - MIDDLE) / MIDDLE_SPREAD) ** 2
    x, sign = np.log(cases[:, 0]), 2 * cases[:, 1] - 1
    argument = sign * (x - middles[:, None]) / np.exp(widths)[:, None, None]
    return np.asarray(log_ndtr(argument).sum(-1) + prior)


def _log_sum(density: np.ndarray) -> np.ndarray:
    top = density.max(1)
    return np.asarray(top + np.log(np.exp(density - top[:, None]).sum(1)))


def _quantiles(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    order = np.argsort(values, axis=None)
    below = np.cumsum(weights.ravel()[order])
    return np.asarray(np.interp(INTERVAL, below / below[-1], values.ravel()[order]))
