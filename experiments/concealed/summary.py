"""Many scores as a few numbers for each table, a confusion matrix and a list of misses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .calibration import calibration_curve, first_stated
from .mechanisms import FLOOR, GROUND, SENSOR, STOREY
from .score import effects_of, pair_of, words
from .shares import median, share
from .tables import KNOWN

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

ORDER = tuple(dict.fromkeys(("none", *STOREY, *FLOOR, *GROUND, *SENSOR, "sensor_swap")))
SHARES = ("right", "first_right", "place_right", "verdict_right", "improved", "false_alarm")
MEDIANS = (
    "strength_error", "explained_over_true", "explained_over_true_ahead",
    "noise_floor_over_true", "noise_floor_over_true_ahead", "seconds",
)  # fmt: skip

WITHIN = 0.1
"""How far a stated share may be from the true one."""


def summarise(results: Mapping[str, dict[str, Any]]) -> dict[str, Any]:
    """Return the numbers of a campaign.

    Args:
        results: of ``campaign.run``, by case; truth and score are looked at.

    Returns:
        tables: by table, ``numbers_of`` its cases.
        all: the same of all cases with something concealed.
        calibration: of the first finding's probability; calibration_all: of all that was named.
        worse_ahead: cases whose explained error, two seconds ahead, is above the calibrated, with
            its ratio to that and to the true model's.
        misses: ``misses``.
        confusion: names and counts, of cases with at most one effect.
    """
    by_table: dict[str, list[dict[str, Any]]] = {}
    for result in results.values():
        by_table.setdefault(table_of(result["truth"]), []).append(result["score"])
    hidden = [r["score"] for r in results.values() if effects_of(r["truth"])]
    scores = [r["score"] for r in results.values()]
    names, counts = confusion(results)
    return {
        "tables": {name: numbers_of(by_table[name]) for name in _ordered(by_table)},
        "all": numbers_of(hidden),
        "calibration": calibration_curve(first_stated(scores)),
        "calibration_all": calibration_curve(tuple(one) for s in scores for one in s["stated"]),
        "worse_ahead": [
            {
                "case": case,
                "ratio": r["score"]["explained_over_calibrated_ahead"],
                "over_true": r["score"]["explained_over_true_ahead"],
            }
            for case, r in results.items()
            if r["score"]["ahead_not_worse"] is False
        ],
        "misses": misses(results),
        "confusion": {"names": names, "counts": counts.tolist()},
    }


def numbers_of(scores: list[dict[str, Any]]) -> dict[str, Any]:
    """Return shares with intervals, and medians, of some scores.

    ``alone`` is the share of cases in which nothing but the truth was named, ``spurious`` that in
    which something else was; ``ahead_not_worse`` and ``share_near`` (the share explained is stated
    within ``WITHIN``) are of those that have the number.
    """
    ahead = [s["ahead_not_worse"] for s in scores if s["ahead_not_worse"] is not None]
    apart = [s.get("share_error") for s in scores]
    return {
        "cases": len(scores),
        **{key: share(s[key] for s in scores) for key in SHARES},
        "alone": share(s["right"] and not s["besides"] for s in scores),
        "spurious": share(s["besides"] for s in scores),
        "ahead_not_worse": share(ahead),
        "share_near": share(error <= WITHIN for error in apart if error is not None),
        **{key: median(s[key] for s in scores) for key in MEDIANS},
    }


def table_of(truth: Mapping[str, Any]) -> str:
    """Return the table of a case; earlier campaigns had two."""
    return str(truth.get("table") or ("none" if truth["mechanism"] == "none" else "single"))


def concealed_words(truth: Mapping[str, Any]) -> str:
    """Return "bumper storey2 and mass floor1"; "none" where nothing is concealed."""
    return " and ".join(words(pair_of(effect)) for effect in effects_of(truth)) or "none"


def misses(results: Mapping[str, dict[str, Any]]) -> list[dict[str, Any]]:
    """Return every case that was not answered right, with what was said instead."""
    return [
        {
            "case": case,
            "table": table_of(r["truth"]),
            "truth": concealed_words(r["truth"]),
            "found": " and ".join(r["score"]["named"]) or r["score"]["found"],
            "rank": r["score"]["rank"],
            "probability": r["score"]["probability"],
            "effect_over_noise": r["truth"].get("effect_over_noise"),
            "noise": r["truth"].get("noise"),
            "reason": r["diagnosis"].get("error", r["diagnosis"].get("verdict")),
        }
        for case, r in results.items()
        if not r["score"]["right"]
    ]


def confusion(results: Mapping[str, dict[str, Any]]) -> tuple[list[str], np.ndarray]:
    """Return the mechanisms and how often each (row) was named first as each (column)."""
    pairs = []
    for r in results.values():
        effects = effects_of(r["truth"])
        if len(effects) < 2:
            true = effects[0]["mechanism"] if effects else "none"
            pairs.append((true, r["score"]["found"].split(" ")[0]))
    met = {name for pair in pairs for name in pair}
    names = [name for name in ORDER if name in met] + sorted(met - set(ORDER))
    counts = np.zeros((len(names), len(names)), int)
    for true, found in pairs:
        counts[names.index(true), names.index(found)] += 1
    return names, counts


def _ordered(tables: Iterable[str]) -> list[str]:
    given = list(tables)
    return [name for name in KNOWN if name in given] + sorted(set(given) - set(KNOWN))
