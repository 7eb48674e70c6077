"""Shares with their exact 95 % intervals, and medians."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from scipy.stats import binomtest

CONFIDENCE = 0.95


def share(outcomes: Iterable[Any]) -> dict[str, Any]:
    """Return how many are true, of how many, the share and its Clopper-Pearson interval.

    Returns:
        count, of, share, low, high; the last three are None where there is nothing to count.
    """
    given = [bool(one) for one in outcomes]
    if not given:
        return {"count": 0, "of": 0, "share": None, "low": None, "high": None}
    found = binomtest(sum(given), len(given)).proportion_ci(CONFIDENCE, method="exact")
    return {
        "count": sum(given),
        "of": len(given),
        "share": sum(given) / len(given),
        "low": float(found.low),
        "high": float(found.high),
    }


def median(values: Iterable[float | None]) -> float | None:
    """Return the median of the values that there are."""
    given = [value for value in values if value is not None]
    return float(np.median(given)) if given else None
