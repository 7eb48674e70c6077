"""Many scores as a few numbers, a confusion matrix and a list of misses, printed and drawn."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.table import Table

from twin.files import write_whole

from .mechanisms import FLOOR, GROUND, SENSOR, STOREY

if TYPE_CHECKING:
    from collections.abc import Mapping

ORDER = tuple(dict.fromkeys(("none", *STOREY, *FLOOR, *GROUND, *SENSOR, "sensor_swap")))


def summarise(results: Mapping[str, dict[str, Any]]) -> dict[str, Any]:
    """Return the numbers of a campaign: shares, medians, misses and the confusion matrix.

    Args:
        results: of ``campaign.run``, by case.
    """
    hidden = [r["score"] for r in results.values() if r["truth"]["mechanism"] != "none"]
    quiet = [r["score"] for r in results.values() if r["truth"]["mechanism"] == "none"]
    names, counts = confusion(results)
    return {
        "cases": len(hidden),
        "right": _share(hidden, "right"),
        "place_right": _share(hidden, "place_right"),
        "verdict_right": _share(hidden, "verdict_right"),
        "strength_error": _median(hidden, "strength_error"),
        "explained_over_true": _median(hidden, "explained_over_true"),
        "explained_over_true_ahead": _median(hidden, "explained_over_true_ahead"),
        "none": len(quiet),
        "false_alarms": sum(s["false_alarm"] for s in quiet),
        "seconds": _median([*hidden, *quiet], "seconds"),
        "misses": misses(results),
        "confusion": {"names": names, "counts": counts.tolist()},
    }


def misses(results: Mapping[str, dict[str, Any]]) -> list[dict[str, Any]]:
    """Return every case whose first finding is not the truth, with what was found instead."""
    return [
        {
            "case": case,
            "truth": f"{r['truth']['mechanism']} {r['truth']['location']}".strip(),
            "found": r["score"]["found"],
            "rank": r["score"]["rank"],
            "probability": r["score"]["probability"],
            "effect_over_noise": r["truth"]["effect_over_noise"],
            "noise": r["truth"]["noise"],
            "reason": r["diagnosis"].get("error", r["diagnosis"].get("verdict")),
        }
        for case, r in results.items()
        if not r["score"]["right"]
    ]


def confusion(results: Mapping[str, dict[str, Any]]) -> tuple[list[str], np.ndarray]:
    """Return the mechanisms and how often each (row) was named as each (column)."""
    pairs = [(r["truth"]["mechanism"], r["score"]["found"].split(" ")[0]) for r in results.values()]
    met = {name for pair in pairs for name in pair}
    names = [name for name in ORDER if name in met] + sorted(met - set(ORDER))
    counts = np.zeros((len(names), len(names)), int)
    for true, found in pairs:
        counts[names.index(true), names.index(found)] += 1
    return names, counts


def show(console: Console, summary: dict[str, Any]) -> None:
    """Print the numbers, the confusion matrix and the misses."""
    table = Table(title="concealed cases", show_header=False)
    rows = {
        f"right mechanism and place first, of {summary['cases']}": _percent(summary["right"]),
        "right place": _percent(summary["place_right"]),
        "right verdict": _percent(summary["verdict_right"]),
        "error of the strength, median": _percent(summary["strength_error"]),
        "explained over true model, free run, median": _number(summary["explained_over_true"]),
        "the same two seconds ahead": _number(summary["explained_over_true_ahead"]),
        f"false alarms, of {summary['none']} with nothing concealed": str(summary["false_alarms"]),
        "seconds a diagnosis, median": _number(summary["seconds"]),
    }
    for name, value in rows.items():
        table.add_row(name, value)
    console.print(table)
    names, counts = summary["confusion"]["names"], summary["confusion"]["counts"]
    matrix = Table(title="concealed (rows), named first (columns)", pad_edge=False)
    matrix.add_column("")
    for i in range(len(names)):
        matrix.add_column(str(i + 1), justify="right", min_width=2, no_wrap=True)
    for i, (name, row) in enumerate(zip(names, counts, strict=True)):
        matrix.add_row(f"{i + 1} {name}", *(str(n) if n else "" for n in row))
    console.print(matrix)
    if summary["misses"]:
        console.print(_missed(summary["misses"]))


def draw_confusion(summary: dict[str, Any], path: Path) -> Path:
    """Draw the confusion matrix and return the picture's path."""
    from matplotlib.figure import Figure

    names = summary["confusion"]["names"]
    counts = np.array(summary["confusion"]["counts"], float)
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    labels = [name.replace("_", " ") for name in names]
    size = 2.5 + 0.36 * len(names)
    figure = Figure(figsize=(size + 1, size), layout="constrained")
    ax = figure.subplots()
    ax.imshow(share, cmap="Blues", vmin=0, vmax=1)
    ax.set_xticks(range(len(names)), labels, rotation=90)
    ax.set_yticks(range(len(names)), labels)
    ax.set_xlabel("named first")
    ax.set_ylabel("concealed")
    for (i, j), count in np.ndenumerate(counts):
        if count:
            colour = "white" if share[i, j] > 0.5 else "black"
            ax.text(j, i, f"{count:.0f}", ha="center", va="center", color=colour, fontsize=8)
    return write_whole(path, lambda part: figure.savefig(part, dpi=150))


def _missed(entries: list[dict[str, Any]]) -> Table:
    table = Table(title="misses")
    for name in ("case", "concealed", "named first", "probability", "truth ranks", "effect", "why"):
        table.add_column(name)
    for m in entries:
        table.add_row(
            m["case"], m["truth"], m["found"], _number(m["probability"]),
            "-" if m["rank"] is None else str(m["rank"]),
            f"{m['effect_over_noise']:.0f} x noise", str(m["reason"]),
        )  # fmt: skip
    return table


def _share(scores: list[dict[str, Any]], key: str) -> float | None:
    return sum(bool(s[key]) for s in scores) / len(scores) if scores else None


def _median(scores: list[dict[str, Any]], key: str) -> float | None:
    values = [s[key] for s in scores if s[key] is not None]
    return float(np.median(values)) if values else None


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{100 * value:.1f} %"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"
