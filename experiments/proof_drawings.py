"""Pictures of the proof page; every function returns a Matplotlib figure and saves nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from twin.view.colours import FRAME, GROUND, IDENTIFIED, MEASURED, TRUE

TOLD_APART = 0.35
"""Height over which the points of one table are spread."""

FARTHEST = 1e3
"""Ratios beyond this, of runs that diverge, are arrows at the edge."""

Rows = Sequence[Mapping[str, Any]]


def rates(tables: Mapping[str, Mapping[str, Any]], aims: Mapping[str, float]) -> Figure:
    """Draw the share of right answers of each table with its interval, and the aim."""
    names = list(tables)
    figure = Figure(figsize=(8, 1.3 + 0.42 * len(names)), layout="constrained")
    ax = figure.subplots()
    for row, name in enumerate(names):
        of = tables[name]["right"]
        ends = [100 * of["low"], 100 * of["high"]]
        ax.plot(ends, [row, row], color=MEASURED, lw=6, alpha=0.5, solid_capstyle="butt")
        ax.plot(100 * of["share"], row, "o", color=TRUE, ms=7)
        if name in aims:
            ax.plot([100 * aims[name]] * 2, [row - 0.35, row + 0.35], color=IDENTIFIED, lw=2)
    ax.plot([], [], "o", color=TRUE, label="right")
    ax.plot([], [], color=MEASURED, lw=6, alpha=0.5, label="95 % interval")
    ax.plot([], [], color=IDENTIFIED, lw=2, label="aim")
    ax.set_yticks(range(len(names)), [f"{n} ({tables[n]['cases']})" for n in names])
    ax.set_ylim(len(names) - 0.4, -0.6)
    ax.set_xlim(0, 102)
    ax.set_xlabel("cases answered right [%]")
    ax.set_ylabel("table (cases)")
    ax.grid(alpha=0.3, axis="x")
    figure.legend(loc="outside upper center", ncols=3, frameon=False, fontsize=9)
    return figure


def calibration(panels: Mapping[str, Rows]) -> Figure:
    """Draw how often a stated probability was right, one panel for each title."""
    figure = Figure(figsize=(0.8 + 4 * len(panels), 4.6), layout="constrained")
    axes = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    for ax, (title, bins) in zip(axes, panels.items(), strict=True):
        _curve(ax, bins)
        ax.set_title(title, fontsize=10)
        ax.set_xlabel("stated probability")
    axes[0].set_ylabel("share that was right")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3,
                  frameon=False, fontsize=9)  # fmt: skip
    return figure


def _curve(ax: Axes, bins: Rows) -> None:
    for at, one in enumerate(bins):
        of = one["right"]
        ends = [of["low"], of["high"]]
        ax.plot([at, at], ends, color=MEASURED, lw=5, alpha=0.5, solid_capstyle="butt")
        ax.plot([at - 0.3, at + 0.3], [one["probability"]] * 2, color=GROUND, lw=1.5)
        ax.plot(at, of["share"], "o", color=TRUE)
        ax.text(at, -0.07, f"{of['count']}/{of['of']}", fontsize=8, ha="center", va="center")
    ax.plot([], [], color=GROUND, lw=1.5, label="stated")
    ax.plot([], [], "o", color=TRUE, label="share that was right (counts below)")
    ax.plot([], [], color=MEASURED, lw=5, alpha=0.5, label="95 % interval")
    ax.set_xticks(range(len(bins)), [f"{one['from']:g} to {one['to']:g}" for one in bins],
                  rotation=30, ha="right", fontsize=8)  # fmt: skip
    ax.set_xlim(-0.6, len(bins) - 0.4)
    ax.set_ylim(-0.12, 1.04)
    ax.grid(alpha=0.3, axis="y")


def fit_ratios(rows: Rows) -> Figure:
    """Draw the explained error over the true model's of every case, free and two seconds ahead."""
    tables = list(dict.fromkeys(row["truth"]["table"] for row in rows))
    figure = Figure(figsize=(9, 1.5 + 0.5 * len(tables)), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    for ax, key, title in (
        (axes[0], "explained_over_true", "free run"),
        (axes[1], "explained_over_true_ahead", "two seconds ahead"),
    ):
        for level, table in enumerate(tables):
            _strip(ax, [r["score"] for r in rows if r["truth"]["table"] == table], key, level)
        ax.axvline(1, color=GROUND, lw=1, ls="--")
        ax.set_xscale("log")
        ax.set_title(title, fontsize=10)
        ax.set_xlabel("explained error / the true model's")
        ax.set_yticks(range(len(tables)), tables)
        ax.set_ylim(len(tables) - 0.4, -0.6)
        ax.grid(alpha=0.3, axis="x")
        ax.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        ax.xaxis.set_minor_formatter(FuncFormatter(lambda v, _: ""))
    axes[0].set_ylabel("table")
    for label, colour in (("answered right", TRUE), ("missed", IDENTIFIED)):
        axes[0].plot([], [], "o", ms=4, color=colour, label=label)
    axes[0].plot([], [], "|", ms=14, mew=2, color="black", label="median")
    axes[0].plot([], [], ">", ms=6, color=GROUND, label=f"beyond {FARTHEST:g}")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=4, frameon=False, fontsize=9)
    return figure


def _strip(ax: Axes, scores: Rows, key: str, level: int) -> None:
    """Draw the ratios of a table along one level, spread so that points can be told apart."""
    given = [score for score in scores if score[key]]
    if not given:
        return
    ratios = np.array([score[key] for score in given])
    spread = TOLD_APART * ((0.618034 * np.arange(len(given))) % 1 - 0.5)
    colours = np.array([TRUE if score["right"] else IDENTIFIED for score in given])
    inside = ratios <= FARTHEST
    for these, marker, size in ((inside, "o", 9), (~inside, ">", 40)):
        at = np.minimum(ratios[these], FARTHEST), (level + spread)[these]
        ax.scatter(*at, s=size, c=colours[these], marker=marker, linewidths=0)
    ax.plot(np.median(ratios), level, "|", ms=20, mew=2, color="black")


def limits(curves: Rows) -> Figure:
    """Draw detection limits: the smallest severity found against something, and in theory.

    Args:
        curves: title, x_label, y_label, x, found and limit (lists; null where there is none).
    """
    columns = min(4, len(curves))  # noise and length side by side
    lines = -(-len(curves) // columns)
    figure = Figure(figsize=(3.3 * columns, 2.7 * lines + 0.4), layout="constrained")
    axes = figure.subplots(lines, columns, squeeze=False).ravel()
    for ax, curve in zip(axes, curves, strict=False):
        x = np.array(curve["x"], float)
        for key, colour, style in (("found", TRUE, "o-"), ("limit", GROUND, "--")):
            ax.loglog(x, np.array(curve[key], float), style, color=colour, ms=4, label=key)
        ax.set_title(curve["title"], fontsize=9)
        ax.set_xlabel(curve["x_label"], fontsize=8)
        ax.set_ylabel(curve["y_label"], fontsize=8)
        ax.grid(alpha=0.3, color=FRAME)
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter(NullFormatter())
        ax.tick_params(labelsize=7)
    for ax in axes[len(curves) :]:
        ax.remove()
    handles, _ = axes[0].get_legend_handles_labels()
    labels = ["smallest found in 90 % of the cases", "likelihood ratio of the true model"]
    figure.legend(handles, labels, loc="outside upper center", ncols=2, frameon=False, fontsize=9)
    return figure
