"""Are the stated probabilities right as often as they say?"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from .shares import share

EDGES = (0.0, 0.05, 0.25, 0.5, 0.7, 0.85, 0.95, 0.99, 1.0)
"""Of the bins; the one from 0.85 to 0.95 is "when it says 0.9"."""

Stated = tuple[float, bool]
"""A stated probability, and whether it was right."""


def first_stated(scores: Iterable[Mapping[str, Any]]) -> list[Stated]:
    """Return the first findings' probabilities, and whether they were right."""
    return [
        (s["probability"], bool(s["first_right"] and not s["false_alarm"]))
        for s in scores
        if s["probability"] is not None
    ]


def calibration_curve(stated: Iterable[Stated]) -> list[dict[str, Any]]:
    """Return the bins that hold something.

    Returns:
        For each: low and high edge under "from" and "to", mean stated "probability", and "right":
        the share that was right, with its interval.
    """
    pairs = list(stated)
    bins = np.clip(np.searchsorted(EDGES, [p for p, _ in pairs], side="right") - 1, 0, None)
    bins = np.minimum(bins, len(EDGES) - 2)
    curve = []
    for i, (low, high) in enumerate(pairwise(EDGES)):
        inside = [pair for pair, at in zip(pairs, bins, strict=True) if at == i]
        if inside:
            probability = float(np.mean([p for p, _ in inside]))
            entry = {"from": low, "to": high, "probability": probability}
            curve.append({**entry, "right": share(right for _, right in inside)})
    return curve
