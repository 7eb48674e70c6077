"""Detection limits as a document: text, tables and curves for the page of the proof."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.detection_limits_probit import Found, probit
from experiments.detection_limits_rivals import names_at
from experiments.detection_limits_theory import (
    CANDIDATES,
    FALSE_ALARM,
    PAIRS,
    Pair,
    needed_nats,
)

Rows = Sequence[dict[str, Any]]

COMMAND = "python experiments/detection_limits.py FOLDER --budget 35"
FEWEST = 3
"""A group of fewer cases gets no number of its own."""

FACTOR = 2.0
TEXT = """\
The theoretical limit is the severity at which an ideal test that knows the {candidates} \
candidates (mechanism and place) would find the effect in 90 % of the cases. L is half the \
squared distance, in units of the noise on the outputs and on the measured force, between the \
training recordings with the effect and the nearest frame without it, all masses, stiffnesses \
and dampings free (of storeys, and of floors against the ground). The logarithm of the \
likelihood ratio of the true model is then normal, mean L, variance 2 L; to beat \
ln({candidates}/{alarm:g}) = {bar:.2f} nats in 90 % of the cases, L - 1.2816 sqrt(2 L) must be \
that much: L = {nats:.2f} nats. The limit is solved for in every case, along its own motion. The \
ideal test is told nothing of the frame; `twin diagnose` is told the drawing and how well it is \
known (0.4 % of masses and stiffnesses), which can put it below the limit where a change of mass \
or stiffness is confused with the effect.

Measured: {cases} cases, each with a rig, plan, filter and noise of its own drawn as in the \
concealed campaign, one effect of {low:g} to {high:g} times the limit of that case; found means \
mechanism and place named first. A probit curve in the logarithm of the severity over the limit is \
fitted to each effect, all of one width, with a weak prior (half found at 1.4 times the limit, \
within a factor of e; median and 95 % interval of the posterior are given). Where all cases of a \
condition were found, or none, the data bound the severity on one side only, and no number is \
given. Which severities the other conditions get, and which effects are tried stronger, was set \
after the first condition had been seen. Within a factor of {factor:g} of the limit: {within} of \
{pairs} effects ({sure} with their whole interval).

The limit says that something is there; to name it, a test must tell it from the other candidates, \
too, each with the strength and the frame that suit it best. With one rival that is apart by R \
nats, nine of ten are right when R - 1.2816 sqrt(2 R) = 0, R = 3.28. Where the nearest rival is \
closer than that at the limit, a test that knows nothing of the frame cannot name nine of ten \
there: the limit of naming is as many times higher as makes R = 3.28. A ratio below one is the \
drawing's help or luck: the median of the probabilities that were stated with the right answers \
says which. Within a factor of {factor:g} of the limit of naming: {naming} of \
{pairs} effects."""


def document(rows: Rows, limits: Rows, rivals: Rows) -> dict[str, Any]:
    """Return text, tables, curves and everything that they were made from."""
    groups = probit(_grouped(rows, lambda row: _title(row)))
    parts = probit(_grouped(rows, lambda row: f"{_title(row)} {_condition(row)}"))
    within = [f for f in groups.values() if f.ratio <= FACTOR]
    multiples = sorted({row["multiple"] for row in rows})
    text = TEXT.format(
        candidates=CANDIDATES, alarm=FALSE_ALARM, bar=np.log(CANDIDATES / FALSE_ALARM),
        nats=needed_nats(), cases=len(rows), low=multiples[0], high=multiples[-1], factor=FACTOR,
        within=len(within), pairs=len(groups), sure=sum(f.high <= FACTOR for f in within),
        naming=sum(
            groups[p.title].ratio <= FACTOR * _naming(p, rivals) for p in PAIRS if p.title in groups
        ),
    )  # fmt: skip
    return {
        "text": text,
        "command": COMMAND,
        "tables": [
            _of_pairs(rows, groups, rivals),
            _of_conditions(rows, parts),
            _of_multiples(rows, multiples),
            _of_misses(rows),
            _of_rivals(rivals),
        ],
        "curves": _curves(rows, limits, parts),
        "needed_nats": needed_nats(),
        "ratios": {name: vars(found) for name, found in groups.items()},
        "ratios_by_condition": {name: vars(found) for name, found in parts.items()},
        "cases": list(rows),
        "limits": list(limits),
        "rivals": list(rivals),
    }


def show(made: dict[str, Any]) -> None:
    """Print the tables."""
    console = Console(width=150)
    for one in made["tables"]:
        table = Table(*one["columns"], title=one["title"])
        for row in one["rows"]:
            table.add_row(*map(str, row))
        console.print(table)


def _title(row: dict[str, Any]) -> str:
    return f"{row['mechanism']} {row['place']}"


def _condition(row: dict[str, Any]) -> str:
    length = "full length" if row["length"] > 0.99 else "a third of the length"
    return f"noise {100 * row['noise']:g} %, {length}"


def _grouped(
    rows: Rows, key: Callable[[dict[str, Any]], str]
) -> dict[str, list[tuple[float, bool]]]:
    found: dict[str, list[tuple[float, bool]]] = {}
    for row in rows:
        found.setdefault(key(row), []).append((row["multiple"], row["found"]))
    return found


def _conditions(rows: Rows) -> list[str]:
    return list(dict.fromkeys(_condition(row) for row in rows))


def _of(rows: Rows, pair: Pair) -> list[dict[str, Any]]:
    return [row for row in rows if _title(row) == pair.title]


def _limit(pair: Pair, rows: Rows) -> float:
    """Return the median limit of a pair's cases in the first condition, as shown."""
    first = _condition(rows[0])
    limits = [row["limit"] for row in _of(rows, pair) if _condition(row) == first]
    return float(np.median(limits)) * pair.shown


def _shown(value: float) -> str:
    return f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def _of_pairs(rows: Rows, groups: dict[str, Found], rivals: Rows) -> dict[str, Any]:
    columns = [
        "Mechanism", "Place", "Severity", "Unit", "Theoretical limit", "Found in 90 %",
        "Over the limit", "95 % interval", "Over the limit of naming", "Found",
        "Probability stated, right answers",
    ]  # fmt: skip
    table = []
    for pair in (pair for pair in PAIRS if pair.title in groups):
        found, limit = groups[pair.title], _limit(pair, rows)
        table.append([
            pair.name, pair.place, pair.severity, pair.unit, _shown(limit),
            _shown(limit * found.ratio), f"{found.ratio:.2f}",
            f"{found.low:.2f} to {found.high:.2f}", f"{found.ratio / _naming(pair, rivals):.2f}",
            f"{found.found} of {found.of}", _stated(_of(rows, pair)),
        ])  # fmt: skip
    title = f"Smallest severities ({_condition(rows[0])}; ratios from all cases)"
    return {"title": title, "columns": columns, "rows": table}


def _naming(pair: Pair, rivals: Rows) -> float:
    """Return the severity over the limit at which an ideal test names the effect, too."""
    return names_at(float(np.median([one["rivals"][pair.title][1] for one in rivals])))


def _stated(rows: Rows) -> str:
    """Return the median of the probabilities that were stated with right answers."""
    stated = [row["probability"] for row in rows if row["found"]]
    return f"{np.median(stated):.2f}" if stated else "-"


def _of_conditions(rows: Rows, parts: dict[str, Found]) -> dict[str, Any]:
    table = []
    for pair in PAIRS:
        cells = []
        for condition in _conditions(rows):
            one = parts.get(f"{pair.title} {condition}")
            tried = [r["multiple"] for r in _of(rows, pair) if _condition(r) == condition]
            cells.append(f"{_ratio(one, tried)} ({one.found} of {one.of})" if one else "-")
        table.append([pair.title, *cells])
    title = (
        "Severity found in 90 % over the limit of the same condition, 95 % interval (cases found)"
    )
    return {"title": title, "columns": ["Effect", *_conditions(rows)], "rows": table}


def _ratio(one: Found, tried: Sequence[float]) -> str:
    """Return the ratio of a group, or what is known where one side alone was seen."""
    if not _two_sided(one):
        return f"all from x {min(tried):g}" if one.found else f"none to x {max(tried):g}"
    return f"{one.ratio:.2f}, {one.low:.2f} to {one.high:.2f}"


def _two_sided(one: Found) -> bool:
    """Return whether some cases of a group were found and some were not."""
    return one.of >= FEWEST and 0 < one.found < one.of


def _of_multiples(rows: Rows, multiples: Sequence[float]) -> dict[str, Any]:
    def cell(some: Rows, multiple: float) -> str:
        hits = [row["found"] for row in some if row["multiple"] == multiple]
        return f"{sum(hits)} of {len(hits)}" if hits else "-"

    table = [[pair.title, *(cell(_of(rows, pair), m) for m in multiples)] for pair in PAIRS]
    table.append(["all", *(cell(rows, m) for m in multiples)])
    columns = ["Effect", *(f"x {m:g}" for m in multiples)]
    return {"title": "Found, by severity over the limit", "columns": columns, "rows": table}


def _of_misses(rows: Rows) -> dict[str, Any]:
    """Return what was said instead of the effects that an ideal test finds."""
    table = []
    for pair in PAIRS:
        missed = [r for r in _of(rows, pair) if not r["found"] and r["multiple"] >= 1]
        said = Counter(row["first"].partition(":")[0] for row in missed).most_common()
        words = ", ".join(f"{name} ({count})" for name, count in said)
        table.append([pair.title, len(missed), words or "-"])
    columns = ["Effect", "Missed at the limit or above", "Said first instead"]
    return {"title": "What was said instead", "columns": columns, "rows": table}


def _of_rivals(rivals: Rows) -> dict[str, Any]:
    """Return what an effect at its limit is most easily taken for, by any test."""
    table = []
    for pair in PAIRS:
        names, apart = zip(*(one["rivals"][pair.title] for one in rivals), strict=True)
        middle = float(np.median(apart))
        table.append([
            pair.title, ", ".join(dict.fromkeys(names)), f"{middle:.1f}",
            f"{_naming(pair, rivals):.2f}",
        ])  # fmt: skip
    columns = ["Effect", "Nearest rival", "Nats between the two", "Told apart in 90 % at x limit"]
    title = "What an effect at the limit is most easily taken for, by any test"
    return {"title": title, "columns": columns, "rows": table}


def _curves(rows: Rows, limits: Rows, parts: dict[str, Found]) -> list[dict[str, Any]]:
    """Return limits against noise and against length, the measured ratios times them."""
    curves = []
    for pair in PAIRS:
        noise: dict[float, list[float]] = {one["noise"]: [] for one in limits if not one["seconds"]}
        length: dict[float, list[float]] = {one["seconds"]: [] for one in limits if one["seconds"]}
        for one in limits:
            axis, at = (length, one["seconds"]) if one["seconds"] else (noise, one["noise"])
            axis[at].append(one["limits"][pair.title] * pair.shown)
        measured = _measured(rows, pair, parts)
        for axis, of, scale, label in (
            (noise, 0, 100.0, "noise [% of RMS]"),
            (length, 1, 1.0, "length of a recording [s]"),
        ):
            at = {_nearest(axis, point[of]): ratio for point, ratio in measured if point[of]}
            middle = {x: float(np.median(values)) for x, values in sorted(axis.items())}
            curves.append({
                "title": pair.title,
                "x_label": label,
                "y_label": f"{pair.severity} [{pair.unit}]",
                "x": [x * scale for x in middle],
                "found": [at[x] * limit if x in at else None for x, limit in middle.items()],
                "limit": list(middle.values()),
            })  # fmt: skip
    return curves


def _measured(
    rows: Rows, pair: Pair, parts: dict[str, Found]
) -> list[tuple[tuple[float, float], float]]:
    """Return (noise, seconds) and ratio of the conditions; 0 where one is on no such curve."""
    found = []
    for condition in _conditions(rows):
        some = [row for row in _of(rows, pair) if _condition(row) == condition]
        one = parts.get(f"{pair.title} {condition}")
        if one is None or not _two_sided(one):
            continue
        noise, length = some[0]["noise"], some[0]["length"]
        seconds = float(np.median([row["seconds_recorded"] for row in some]))
        on_curve = (noise if length > 0.99 else 0.0, seconds if noise == rows[0]["noise"] else 0.0)
        found.append((on_curve, one.ratio))
    return found


def _nearest(axis: dict[float, Any], value: float) -> float:
    return min(axis, key=lambda x: abs(np.log(x / value)))
