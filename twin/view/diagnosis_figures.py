"""Figures of a diagnosis; every function returns a Matplotlib figure and saves nothing."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray

from twin.diagnosis.result import Detection, Diagnosis, Finding, Trace
from twin.place import split_channel
from twin.quantity import KIND_NAMES
from twin.view.colours import GROUND, IDENTIFIED, MEASURED, REJECTED, SERIES, TRUE
from twin.view.diagnosis_words import (
    p_value,
    percent,
    place_words,
    printable,
    probability,
)
from twin.view.figures import unit_of

Array = NDArray[np.float64]

GUILTY = "#D55E00"
SHOWN_CHANNELS = 4
SHOWN_CANDIDATES = 12
WINDOW_S = 4.0
DECISIVE = 10.0
"""BIC above which the evidence counts as very strong (Kass and Raftery 1995)."""
FONT = {"fontsize": 10, "parse_math": False}


def drawable(text: str) -> str:
    """Return a file's name as Matplotlib's own font can draw it."""
    return "".join(c if ord(c) < 0x530 else "?" for c in printable(text))


def before_after(trace: Trace, window_s: float = WINDOW_S) -> Figure:
    """Draw a recording beside the calibrated and the explained twin, and what is left.

    The window is the one in which the explanation takes most of the error away; the worst
    calibrated channels are drawn. Errors in the legends are those of the whole recording.
    """
    scale = np.sqrt(np.mean(trace.measured**2, axis=0))
    scale = np.where(scale > 0, scale, 1.0)
    residual = {n: getattr(trace, n) - trace.measured for n in ("calibrated", "explained")}
    error = {n: np.sqrt(np.mean(r**2, axis=0)) / scale for n, r in residual.items()}
    shown = sorted(np.argsort(-error["calibrated"], kind="stable")[:SHOWN_CHANNELS])
    lost = ((residual["calibrated"] / scale) ** 2 - (residual["explained"] / scale) ** 2).sum(1)
    start, stop = _telling(lost, round(window_s * trace.sampling_hz))
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
            label = f"{which}, NRMSE {percent(error[which][column])}"
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


def _telling(lost: Array, samples: int) -> tuple[int, int]:
    """Return start and stop of the window with the largest sum."""
    samples = min(max(samples, 2), len(lost))
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
            label = kind.replace("_", " ")
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


def ranking(diagnosis: Diagnosis) -> Figure:
    """Draw what the candidates promised, and how far behind the best the confirmed ones are."""
    promised = sorted(diagnosis.screening, key=lambda row: -row[2])[:SHOWN_CANDIDATES]
    confirmed = (*diagnosis.findings[:1], *diagnosis.alternatives)
    kept = {(f.mechanism.name, f.location) for f in confirmed[1:]}
    best = {(f.mechanism.name, f.location) for f in confirmed[:1]}
    longest = max(len(promised), len(confirmed), 4)
    figure = Figure(figsize=(11, 1.5 + 0.32 * longest), layout="constrained")
    left, right = figure.subplots(1, 2)
    gains = [max(gain, 0.0) for *_, gain in promised]
    colours = [
        GUILTY if (name, place) in best else IDENTIFIED if (name, place) in kept else REJECTED
        for name, place, _ in promised
    ]
    labels = [_candidate(name, place) for name, place, _ in promised]
    bars = left.barh(np.arange(len(gains)), gains, color=colours)
    left.bar_label(bars, [f"{g:.3g}" for g in gains], fontsize=8, padding=3)
    _rows(left, labels)
    left.set_xscale("symlog", linthresh=10)
    left.set_xlabel("promised gain in log likelihood [nat]")
    left.set_title("screened: a first guess, linearised", fontsize=10)
    _confirmed(right, confirmed)
    return figure


def _confirmed(ax: Axes, confirmed: tuple[Finding, ...]) -> None:
    behind = [max(f.delta_bic, 0.0) for f in confirmed]
    colours = [GUILTY if row == 0 else IDENTIFIED for row in range(len(confirmed))]
    bars = ax.barh(np.arange(len(behind)), behind, color=colours)
    texts = [
        f"{'best' if row == 0 else f'{behind[row]:.3g}'}; {probability(f.probability)}"
        for row, f in enumerate(confirmed)
    ]
    ax.bar_label(bars, texts, fontsize=8, padding=3)
    _rows(ax, [_candidate(f.mechanism.name, f.location) for f in confirmed])
    ax.axvline(DECISIVE, color=GROUND, lw=0.8, ls="--", label=f"{DECISIVE:g}: very strong evidence")
    ax.set_xscale("symlog", linthresh=10)
    ax.set_xlim(0, max([5 * max(behind, default=0.0), 100.0]))
    ax.set_xlabel("BIC above that of the best")
    ax.set_title("confirmed by a full fit; probability", fontsize=10)
    ax.legend(loc="upper left", bbox_to_anchor=(0, -0.17), frameon=False, fontsize=8)


def _candidate(name: str, place: str) -> str:
    return f"{name.replace('_', ' ')}, {place_words(place).removeprefix('channel ')}"


def _rows(ax: Axes, labels: list[str]) -> None:
    ax.set_yticks(np.arange(len(labels)), labels, fontsize=9, parse_math=False)
    ax.set_ylabel("candidate")
    ax.set_ylim(max(len(labels), 4) - 0.4, -0.6)
    ax.grid(alpha=0.3, axis="x")
    ax.margins(x=0.25)


def detection(diagnosis: Diagnosis) -> Figure:
    """Draw the one-step error over the noise against the level of the training recordings."""
    kinds: dict[str, list[Detection]] = {}
    for row in diagnosis.detection:
        channel = split_channel(row.channel)
        kinds.setdefault(channel[0] if channel else "channel", []).append(row)
    count = max(len(kinds), 1)
    figure = Figure(figsize=(max(4.6 * count, 7), 4.2), layout="constrained")
    axes = figure.subplots(1, count, sharey=True, squeeze=False)[0]
    for ax, (kind, rows) in zip(axes, kinds.items(), strict=False):
        for number, row in enumerate(rows):
            level = np.asarray(row.level, float).reshape(-1, 2)
            level = level[np.argsort(level[:, 0])]
            ax.loglog(
                level[:, 0], level[:, 1], "os^v"[number % 4] + "-", lw=0.8, ms=6,
                color=SERIES[number % len(SERIES)],
                label=f"{row.channel}: {row.excess:.3g} times noise, p {_equals(row.p_value)}",
            )  # fmt: skip
        ax.axhline(1, color=GROUND, lw=1, ls="--", label="noise alone")
        quantity = KIND_NAMES.get(kind, kind)
        ax.set_xlabel(f"RMS {quantity} of a training recording [{unit_of(rows[0].channel)}]")
        ax.grid(alpha=0.3, which="both")
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
            axis.set_minor_formatter(FuncFormatter(lambda v, _: ""))
        _legend(ax, 1)
    axes[0].set_ylabel("one-step error over noise")
    return figure


def _equals(value: float) -> str:
    text = p_value(value)
    return text if text.startswith("<") else f"= {text}"


def _legend(ax: Axes, columns: int) -> None:
    """Put the legend above the axes, where it covers nothing."""
    ax.legend(
        loc="lower left", bbox_to_anchor=(0, 1.0), ncols=columns, frameon=False, fontsize=9,
        borderaxespad=0.1,
    )  # fmt: skip
