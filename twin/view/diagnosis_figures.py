"""Figures of a diagnosis; every function returns a Matplotlib figure and saves nothing."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray

from twin.diagnosis.result import Diagnosis, Trace
from twin.view.colours import GROUND, IDENTIFIED, MEASURED, REJECTED, TRUE
from twin.view.diagnosis_words import percent, printable, twin_words
from twin.view.figures import unit_of
from twin.view.shown import Figure

Array = NDArray[np.float64]

SHOWN_CHANNELS = 4
WINDOW_S = 4.0
FONT = {"fontsize": 10, "parse_math": False}


def drawable(text: str) -> str:
    """Return a file's name as Matplotlib's own font can draw it."""
    return "".join(c if ord(c) < 0x530 else "?" for c in printable(text))


def before_after(trace: Trace, window_s: float = WINDOW_S) -> Figure:
    """Draw a recording beside the calibrated and the extended twin, and what is left.

    The window is the one in which the explanation takes most of the error away; the worst
    calibrated channels are drawn. Errors in the legends are those of the whole recording.
    """
    residual = {n: getattr(trace, n) - trace.measured for n in ("calibrated", "explained")}
    error = {n: channel_errors(trace, n) for n in residual}
    shown = worst_channels(trace)
    start, stop = telling(trace, window_s)
    time = np.arange(start, stop) / trace.sampling_hz
    count = len(shown)
    figure = Figure(figsize=(9, 0.8 + 2.9 * count), layout="constrained")
    rows = figure.subplots(
        2 * count, 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": [2, 1] * count}
    )[:, 0]
    for number, column in enumerate(shown):
        above, below = rows[2 * number], rows[2 * number + 1]
        name = trace.outputs[column]
        part = slice(start, stop)
        above.plot(time, trace.measured[part, column], color=MEASURED, lw=3, label="measured")
        for which, colour, width in (("calibrated", IDENTIFIED, 1.2), ("explained", TRUE, 1.2)):
            label = f"{twin_words(which)}, NRMSE {percent(error[which][column])}"
            signal = getattr(trace, which)[part, column]
            above.plot(time, signal, color=colour, lw=width, label=label)
            below.plot(time, residual[which][part, column], color=colour, lw=1.0)
        above.set_ylabel(f"{name}\n[{unit_of(name)}]", parse_math=False)
        below.set_ylabel(f"residual\n[{unit_of(name)}]")
        _legend(above, 3)
        for ax in (above, below):
            ax.grid(alpha=0.3)
            ax.margins(x=0)
    figure.align_ylabels(rows)
    rows[-1].set_xlabel("time [s]")
    role = "not seen by the fit" if trace.role == "test" else "seen by the fit"
    seconds = len(trace.measured) / trace.sampling_hz
    some = "" if count == len(trace.outputs) else f"; {count} of {len(trace.outputs)} channels"
    title = f"{drawable(trace.name)}, {role}; NRMSE over all {seconds:.3g} s{some}"
    figure.suptitle(title, **FONT)
    return figure


def channel_errors(trace: Trace, which: str) -> Array:
    """Return the NRMSE of a twin ("calibrated", "explained") by output, (outputs,)."""
    scale = np.sqrt(np.mean(trace.measured**2, axis=0))
    residual = getattr(trace, which) - trace.measured
    return np.asarray(np.sqrt(np.mean(residual**2, axis=0)) / np.where(scale > 0, scale, 1.0))


def worst_channels(trace: Trace) -> list[int]:
    """Return the outputs that the calibrated twin predicts worst, in the recording's order."""
    order = np.argsort(-channel_errors(trace, "calibrated"), kind="stable")[:SHOWN_CHANNELS]
    return sorted(int(c) for c in order)


def telling(trace: Trace, window_s: float) -> tuple[int, int]:
    """Return start and stop of the window in which the explanation takes most of the error away."""
    scale = np.sqrt(np.mean(trace.measured**2, axis=0))
    scale = np.where(scale > 0, scale, 1.0)
    before, after = (
        (getattr(trace, n) - trace.measured) / scale for n in ("calibrated", "explained")
    )
    lost = (before**2 - after**2).sum(axis=1)
    samples = min(max(round(window_s * trace.sampling_hz), 2), len(lost))
    total = np.concatenate([[0.0], np.cumsum(lost)])
    start = int(np.argmax(total[samples:] - total[:-samples]))
    return start, start + samples


def errors(diagnosis: Diagnosis) -> Figure:
    """Draw the errors of the three twins and the noise floor, free and two seconds ahead."""
    figure = Figure(figsize=(9, 3.8), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    kinds = (
        ("nominal", REJECTED),
        ("calibrated", IDENTIFIED),
        ("explained", TRUE),
        ("noise_floor", GROUND),
    )
    for ax, fits, title in (
        (axes[0], diagnosis.fit, "free run over whole recordings"),
        (axes[1], diagnosis.fit_ahead, "two seconds ahead"),
    ):
        for number, (kind, colour) in enumerate(kinds):
            shares = np.array([getattr(e, kind) for e in (fits.train, fits.test)], float)
            heights = np.where(np.isfinite(shares) & (shares > 0), 100 * shares, np.nan)
            at = np.arange(2) + 0.2 * (number - 1.5)
            label = twin_words(kind)
            bars = ax.bar(at, heights, 0.18, color=colour, label=label)
            ax.bar_label(bars, [percent(s) for s in shares], fontsize=7, padding=1)
        ax.set_yscale("log")
        ax.set_xticks([0, 1], ["train", "test (unseen)"])
        ax.set_xlabel("recordings")
        ax.set_title(title, fontsize=10)
        ax.grid(alpha=0.3, axis="y", which="both")
        ax.margins(y=0.12)
    axes[0].set_ylabel("NRMSE [% of RMS]")
    axes[0].yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=4,
                  frameon=False, fontsize=9)  # fmt: skip
    return figure


def _legend(ax: Axes, columns: int) -> None:
    """Put the legend above the axes, where it covers nothing."""
    ax.legend(
        loc="lower left", bbox_to_anchor=(0, 1.0), ncols=columns, frameon=False, fontsize=9,
        borderaxespad=0.1,
    )  # fmt: skip
