"""Figures of where the mismatch is, and of the force that is missing there."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from twin.diagnosis.result import Diagnosis, ForcePicture
from twin.place import Place, split_channel
from twin.view.colours import FRAME, GROUND, MEASURED, REJECTED, TRUE
from twin.view.diagnosis_figures import GUILTY
from twin.view.diagnosis_words import place_words

HALF = 1.0
BAND = 1.96
"""Standard deviations to either side of 95 %."""
SHOWN_POINTS = 4000


def where(diagnosis: Diagnosis) -> Figure:
    """Draw the evidence for a latent force at every place, each beside its place in the frame."""
    floors = len(diagnosis.nominal.floors)
    guilty = [f.location for f in diagnosis.findings]
    heights = {place: _height(place, floors) for place in diagnosis.where}
    top = max([2.0 * floors, *heights.values()])
    size = (9, min(2.2 + 0.62 * (top + 1), 12))
    figure = Figure(figsize=size, layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True, gridspec_kw={"width_ratios": [2, 3]})
    _frame(left, diagnosis, floors, guilty)
    gains = list(diagnosis.where.values())
    first = guilty[0] if guilty else None
    bars = right.barh(
        list(heights.values()), gains, 0.62,
        color=[GUILTY if place == first else REJECTED for place in heights],
    )  # fmt: skip
    right.bar_label(bars, [f"{gain:.4g}" for gain in gains], fontsize=9, padding=4)
    right.axvline(0, color="black", lw=0.8)
    right.set_yticks(list(heights.values()), [place_words(p) for p in heights])
    right.yaxis.set_tick_params(labelleft=True)
    right.set_ylim(-0.9, top + 0.8)
    right.margins(x=0.18)
    right.set_xlabel("gain in log likelihood by a latent force there [nat]")
    right.set_ylabel("place")
    right.grid(alpha=0.3, axis="x")
    return figure


def _height(place: str, floors: int) -> float:
    """Return where a place is drawn: floors at even, storeys at odd heights."""
    try:
        parsed = Place.parse(place)
    except ValueError:
        return 2.0 * floors + 1
    if parsed.kind == "pendulum":
        return 2.0 * floors - 0.6
    return 2.0 * parsed.number - (1 if parsed.kind == "storey" else 0)


def _frame(ax: Axes, diagnosis: Diagnosis, floors: int, guilty: Iterable[str]) -> None:
    """Draw the frame from the side, the guilty places lit."""
    lit = set(guilty)
    for level in range(floors + 1):
        name = f"floor{level}" if level else "ground"
        wide = HALF * (1.35 if level == 0 else 1.0)
        _line(ax, [-wide, wide], [2.0 * level] * 2, GROUND, 7, name in lit)
    for storey in range(1, floors + 1):
        for side in (-HALF, HALF):
            ends = [2.0 * storey - 2, 2.0 * storey]
            _line(ax, [side, side], ends, FRAME, 2.5, f"storey{storey}" in lit)
    if any(output.endswith("_pendulum") for t in diagnosis.traces for output in t.outputs):
        top = 2.0 * floors
        _line(ax, [0, 0.35], [top, top - 1.2], FRAME, 2, "pendulum" in lit)
    faulty = {channel for place in lit for channel in place.split("+")}
    for trace in diagnosis.traces[:1]:
        _instruments(ax, trace.inputs, trace.outputs, faulty)
    ax.set_xlim(-2.3, 2.0)
    ax.set_xticks([])
    ax.set_xlabel(", ".join(place_words(p) for p in sorted(lit)) or "nothing is out of place")
    ax.yaxis.set_visible(False)
    for spine in ax.spines.values():
        spine.set_visible(False)
    entries = [
        Line2D([], [], color=GUILTY, lw=4, label="guilty"),
        Line2D([], [], color=MEASURED, marker=">", ls="none", label="measured force"),
        Line2D([], [], color=TRUE, marker="s", ls="none", label="sensor"),
    ]
    ax.legend(
        handles=entries if lit else entries[1:], loc="lower center", bbox_to_anchor=(0.5, 1.0),
        ncols=3, fontsize=8, frameon=False, columnspacing=1.0, handletextpad=0.4,
    )  # fmt: skip


def _line(ax: Axes, x: list[float], z: list[float], colour: str, width: float, lit: bool) -> None:
    if lit:
        for glow, alpha in ((18, 0.12), (12, 0.2), (7, 0.3)):
            ax.plot(x, z, color=GUILTY, lw=width + glow, alpha=alpha, solid_capstyle="round")
    ax.plot(x, z, color=GUILTY if lit else colour, lw=width + lit, solid_capstyle="butt", zorder=3)


def _instruments(ax: Axes, inputs: Iterable[str], outputs: Iterable[str], faulty: set[str]) -> None:
    for name in inputs:
        channel = split_channel(name)
        if channel and channel[1].kind in ("ground", "floor"):
            z = 2.0 * channel[1].number
            end = -HALF * (1.4 if channel[1].kind == "ground" else 1.05)
            colour = GUILTY if name in faulty else MEASURED
            ax.annotate(
                "", (end, z), (end - 0.7, z),
                arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 2},
            )  # fmt: skip
    for name in outputs:
        channel = split_channel(name)
        if channel and channel[1].kind in ("ground", "floor"):
            x = HALF * (1.2 if channel[1].kind == "ground" else 0.85)
            colour, size = (GUILTY, 13) if name in faulty else (TRUE, 8)
            z = 2.0 * channel[1].number + 0.2
            ax.plot([x], [z], "s", color=colour, ms=size, zorder=4)


def force(picture: ForcePicture) -> Figure:
    """Draw the missing force against drift and against rate, and the law that explains it."""
    figure = Figure(figsize=(11, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True, gridspec_kw={"width_ratios": [3, 2]})
    every = max(-(-len(picture.drift) // SHOWN_POINTS), 1)
    drift, rate = 1e3 * picture.drift[::every], 1e3 * picture.rate[::every]
    latent = picture.latent[::every]
    motion = "drift" if picture.place.startswith("storey") else "displacement"
    for ax, x, shade, name in (
        (left, drift, rate, f"{motion} rate [mm/s]"),
        (right, rate, drift, f"{motion} [mm]"),
    ):
        points = ax.scatter(
            x, latent, c=shade, s=7, cmap="cividis", alpha=0.75, linewidths=0, rasterized=True,
            label="estimated missing force",
        )  # fmt: skip
        figure.colorbar(points, ax=ax, label=name, pad=0.01)
        ax.grid(alpha=0.3)
    _law(left, picture)
    if picture.cycle is not None:
        at, along = np.asarray(picture.cycle, float).T
        left.plot(1e3 * at, along, color=GUILTY, lw=1.6, label="explained law, along the motion")
    left.set_xlabel(f"{motion} of {place_words(picture.place)} [mm]")
    right.set_xlabel(f"{motion} rate of {place_words(picture.place)} [mm/s]")
    left.set_ylabel("missing force [N]")
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper center", ncols=4,
                  frameon=False, fontsize=9)  # fmt: skip
    return figure


def _law(ax: Axes, picture: ForcePicture) -> None:
    if picture.law is None:
        return
    grid = 1e3 * picture.law_drift
    at_rest = "explained law" if picture.cycle is None else "explained law, at rest"
    style = "-" if picture.cycle is None else "--"
    ax.plot(grid, picture.law, style, color=GUILTY, lw=1.8, label=at_rest)
    if picture.law_std is not None:
        spread = BAND * picture.law_std
        ax.fill_between(
            grid, picture.law - spread, picture.law + spread, color=GUILTY, alpha=0.25, lw=0,
            label="95 %",
        )  # fmt: skip
