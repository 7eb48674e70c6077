"""What ``hammer_peers.py`` found, as tables."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

OURS = "ours"
LEAST_SQUARES = ("sdypy-EMA LSCF", "pyOMA2 pLSCF")
WIDENED = 0.10
"""Share by which the issue widens the peers' spread of damping."""

COVERED = 1.96
"""Standard deviations to either side of a 95 % interval."""


def show(console: Console, found: Mapping[str, Any]) -> None:
    """Print all tables."""
    console.print(spreads(found["measured"]))
    if "unseen" in found:
        console.print(foreseen(found["measured"], found["unseen"]))
    for name, rows in found.get("known", {}).items():
        console.print(errors(name, rows, found["draws"]))


def spreads(rows: Iterable[Mapping[str, Any]]) -> Table:
    """Damping [%] of the measured part: range of the medians over single hits and all of them."""
    rows = list(rows)
    names = [name for name in rows[0]["values"] if name != OURS]
    table = Table(
        "mode [Hz]", "ours (single hits)", "off [%]", *names, "in LSCFs' spread", "in all three's",
        title="measured hits, damping [%]",
    )  # fmt: skip
    counts = np.zeros(2, int)
    for row in rows:
        values = row["values"]
        own = [v["damping"] for v in values[OURS].values() if v]
        best = values[OURS]["all"]
        narrow = damping_range(values, LEAST_SQUARES)
        wide = damping_range(values, names)
        centre = centre_frequency(values, LEAST_SQUARES)
        within = [best is not None and inside(best["damping"], x) for x in (narrow, wide)]
        counts += within
        table.add_row(
            f"{row['mode']:.1f}",
            "missing" if best is None else f"{100 * best['damping']:.4f} ({_span(_ends(own))})",
            "" if best is None or centre is None
            else f"{100 * (best['frequency_hz'] / centre - 1):+.3f}",
            *(_span(damping_range(values, (name,))) for name in names),
            *("yes" if x else "no" for x in within),
        )  # fmt: skip
    table.caption = (
        f"off: frequency from the median of {' and '.join(LEAST_SQUARES)}. Within the spread "
        f"widened by {WIDENED:.0%}: {counts[0]} and {counts[1]} of {len(rows)}"
    )
    return table


def foreseen(rows: Iterable[Mapping[str, Any]], unseen: Mapping[str, Any]) -> Table:
    """Errors on a hit that was not fitted, near every mode and in the band."""
    table = Table("mode [Hz]", *unseen, title="hit that was not fitted, error [% of its response]")
    for i, row in enumerate(rows):
        cells = (f"{100 * found['modes'][i]:.1f}" for found in unseen.values())
        table.add_row(f"{row['mode']:.1f}", *cells)
    table.add_row("whole band", *(f"{100 * found['band']:.1f}" for found in unseen.values()))
    return table


def errors(name: str, rows: Iterable[Mapping[str, Any]], draws: int) -> Table:
    """Root mean square errors of damping on a known part, in per cent of the true value."""
    rows = list(rows)
    names = list(rows[0]["values"])
    table = Table("mode [Hz]", "true [%]", *names, title=f"known part, {name}")
    covered: list[bool] = []
    for row in rows:
        cells = []
        for method in names:
            got = [v for v in row["values"][method] if v]
            off = np.array([v["damping"] / row["true"] - 1 for v in got])
            lost = draws - len(got)
            cells.append(
                ("" if not got else f"{100 * np.sqrt(np.mean(off**2)):.1f}")
                + (f" (missing in {lost})" if lost else "")
            )
            if method == OURS:
                covered += [abs(v["damping"] - row["true"]) < COVERED * v["std"] for v in got]
        table.add_row(f"{row['mode']:.2f}", f"{100 * row['true']:.4f}", *cells)
    table.caption = (
        f"error of damping [% of the true value], root mean square of {draws} draws; our 95 % "
        f"intervals hold the true one in {np.mean(covered):.0%} of {len(covered)}"
    )
    return table


def damping_range(values: Mapping[str, Any], names: Iterable[str]) -> tuple[float, float] | None:
    """Return the least and the largest damping that packages find on any hits, or None."""
    return _ends([v["damping"] for name in names for v in values[name].values() if v])


def centre_frequency(values: Mapping[str, Any], names: Iterable[str]) -> float | None:
    """Return the median frequency over packages and hits [Hz], or None."""
    found = [v["frequency_hz"] for name in names for v in values[name].values() if v]
    return float(np.median(found)) if found else None


def inside(damping: float, spread: tuple[float, float] | None) -> bool:
    """Whether a damping lies in a spread that is widened."""
    if spread is None:
        return False
    return (1 - WIDENED) * spread[0] <= damping <= (1 + WIDENED) * spread[1]


def _ends(values: list[float]) -> tuple[float, float] | None:
    return (min(values), max(values)) if values else None


def _span(ends: tuple[float, float] | None) -> str:
    return "none" if ends is None else f"{100 * ends[0]:.4f}-{100 * ends[1]:.4f}"
