"""A campaign's summary on the terminal, and its confusion matrix as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from twin.files import write_whole

COLUMNS = ("table", "cases", "right", "95 %", "first right", "error", "free", "ahead", "s")


def show(console: Console, summary: dict[str, Any]) -> None:
    """Print the numbers, the confusion matrix and the misses."""
    table = Table(title="concealed cases")
    for name in COLUMNS:
        table.add_column(name, justify="left" if name == "table" else "right", no_wrap=True)
    for name, of in summary["tables"].items():
        table.add_row(
            name, str(of["cases"]), percent(of["right"]["share"]), between(of["right"], 0),
            percent(of["first_right"]["share"]), percent(of["strength_error"]),
            number(of["explained_over_true"]), number(of["explained_over_true_ahead"]),
            number(of["seconds"]),
        )  # fmt: skip
    console.print(table)
    console.print(
        "error: of the strength; free, ahead: explained error over the true model's on unseen "
        "recordings; medians"
    )
    if "near" in summary["tables"]:
        of = summary["tables"]["near"]
        console.print(
            f"laws nearly in the vocabulary: something else named besides in "
            f"{of['spurious']['count']} of {of['spurious']['of']}, share explained stated within "
            f"10 points in {of['share_near']['count']} of {of['share_near']['of']}"
        )
    if "none" in summary["tables"]:
        alarms = summary["tables"]["none"]["false_alarm"]
        console.print(
            f"false alarms: {alarms['count']} of {alarms['of']} with nothing concealed "
            f"(95 % interval {between(alarms)})"
        )
    worse = ", ".join(f"{one['case']} ({one['ratio']:.3f})" for one in summary["worse_ahead"])
    console.print(f"two seconds ahead worse than the calibrated twin: {worse or 'none'}")
    console.print(_matrix(summary["confusion"]["names"], summary["confusion"]["counts"]))
    if summary["misses"]:
        console.print(_missed(summary["misses"]))


def draw_confusion(confusion: dict[str, Any], path: Path, dpi: int = 150) -> Path:
    """Draw the confusion matrix and return the picture's path."""
    from matplotlib.figure import Figure

    names = confusion["names"]
    counts = np.array(confusion["counts"], float).reshape(len(names), len(names))
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    labels = [name.replace("_", " ") for name in names]
    size = 2.5 + 0.36 * len(names)
    figure = Figure(figsize=(size + 1, size), layout="constrained")
    ax = figure.subplots()
    ax.set_xlabel("named first")
    ax.set_ylabel("concealed")
    if names:
        ax.imshow(share, cmap="Blues", vmin=0, vmax=1)
    ax.set_xticks(range(len(names)), labels, rotation=90)
    ax.set_yticks(range(len(names)), labels)
    for (i, j), count in np.ndenumerate(counts):
        if count:
            colour = "white" if share[i, j] > 0.5 else "black"
            ax.text(j, i, f"{count:.0f}", ha="center", va="center", color=colour, fontsize=8)
    return write_whole(path, lambda part: figure.savefig(part, dpi=dpi))


def percent(value: float | None) -> str:
    """Return "95.1 %", "-" for no number."""
    return "-" if value is None else f"{100 * value:.1f} %"


def number(value: float | None) -> str:
    """Return three digits, "-" for no number."""
    return "-" if value is None else f"{value:.3g}"


def between(share: dict[str, Any], digits: int = 1) -> str:
    """Return the interval of a share as "90.1-97.9 %"."""
    if share["low"] is None:
        return "-"
    return f"{100 * share['low']:.{digits}f}-{100 * share['high']:.{digits}f} %"


def _matrix(names: list[str], counts: list[list[int]]) -> Table:
    matrix = Table(title="concealed (rows), named first (columns)", pad_edge=False)
    matrix.add_column("")
    for i in range(len(names)):
        matrix.add_column(str(i + 1), justify="right", min_width=2, no_wrap=True)
    for i, (name, row) in enumerate(zip(names, counts, strict=True)):
        matrix.add_row(f"{i + 1} {name}", *(str(n) if n else "" for n in row))
    return matrix


def _missed(entries: list[dict[str, Any]]) -> Table:
    table = Table(title="misses")
    for name in ("case", "concealed", "named", "probability", "truth ranks", "effect", "why"):
        table.add_column(name)
    for m in entries:
        effect = m["effect_over_noise"]
        table.add_row(
            m["case"], m["truth"], m["found"], number(m["probability"]),
            "-" if m["rank"] is None else str(m["rank"]),
            "-" if effect is None else f"{effect:.0f} x noise", str(m["reason"]),
        )  # fmt: skip
    return table
