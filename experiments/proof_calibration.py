"""What the stated probabilities are worth: the sealed cases, and the weak ones beside them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

from experiments.concealed.calibration import EDGES, Stated, calibration_curve, first_stated
from experiments.concealed.pictures import between, percent

COLUMNS = ("Stated", "Mean stated", "Sealed cases", "Weak effects", "Together", "Share",
           "95 % interval")  # fmt: skip

LIMITS, WEAK = "detection_limits.json", "weak_effects.json"
"""Results whose cases are weak by design."""


def table(rows: Iterable[Mapping[str, Any]], results: Path) -> dict[str, Any]:
    """Return columns, rows and curves: how often a first finding was right, by what was stated.

    The sealed cases are mostly too clear for a probability in the middle; those of the detection
    limits and of ``weak_effects.py``, where they have been run, are made to be weak.

    Args:
        rows: the sealed cases.
        results: folder of the weak ones.
    """
    sealed = first_stated(row["score"] for row in rows)
    _, limits = weak_cases(results / LIMITS)
    _, others = weak_cases(results / WEAK)
    weak = [*limits, *others]
    parts = [_bins(sealed), _bins(weak), _bins([*sealed, *weak])]
    out = []
    for low, high in pairwise(EDGES):
        together = parts[2].get(low)
        if together is None:
            continue
        counts = [_count(part.get(low)) for part in parts]
        right = together["right"]
        out.append([f"{low:g} to {high:g}", f"{together['probability']:.3f}", *counts,
                    percent(right["share"]), between(right)])  # fmt: skip
    curve = list(parts[2].values())
    return {"columns": list(COLUMNS), "rows": out, "weak": len(weak), "curve": curve}


def weak_cases(file: Path) -> tuple[list[Stated], list[Stated]]:
    """Return the same of cases that are weak, of the last run and of all of them.

    Both are empty where none has been run.
    """
    if not file.exists():
        return [], []
    last = json.loads(file.read_text())
    runs = [
        [(c["probability"], c["found"]) for c in run["cases"] if c["probability"] is not None]
        for run in (last, *last.get("earlier", []))
    ]
    return runs[0], [case for run in runs for case in run]


def _bins(stated: Iterable[Stated]) -> dict[float, dict[str, Any]]:
    return {one["from"]: one for one in calibration_curve(stated)}


def _count(one: Mapping[str, Any] | None) -> str:
    return f"{one['right']['count']} of {one['right']['of']}" if one else "-"
