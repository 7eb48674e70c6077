"""Figures of an identification; every function returns a Matplotlib figure and saves nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from twin.files import write_whole
from twin.identification.pole_diagram import PoleDiagram, of_responses
from twin.identification.response import identified_response
from twin.identification.result import Identification
from twin.place import split_channel
from twin.quantity import SI_UNIT
from twin.recording import Recording
from twin.signals.frf import FrequencyResponse, measured_response
from twin.view.colours import (
    FORCE,
    GROUND,
    IDENTIFIED,
    MEASURED,
    REJECTED,
    measured_and_identified,
)
from twin.view.deflection import HALF_SPAN, HEIGHT, beam, mode_shapes
from twin.view.poles import draw_poles
from twin.view.shown import Figure

Array = NDArray[np.float64]

DPI = 120
SHOWN_SINGULAR_VALUES = 30


def save(figure: Figure, path: Path) -> Path:
    """Write the figure whole or not at all."""
    return write_whole(path, lambda part: figure.savefig(part, dpi=DPI))


def unit_of(name: str, recordings: Sequence[Recording] = ()) -> str:
    """Return the SI unit of a channel as it is printed, of a recording's or of a frame's."""
    found = [r.channel(name).unit for r in recordings if name in r.names]
    channel = split_channel(name)
    unit = found[0] if found else SI_UNIT[channel[0]] if channel else ""
    return unit.replace("^2", "²").replace("^3", "³")


def time_histories(result: Identification, index: int = 0) -> Figure:
    """Draw inputs and outputs of one recording, measured against re-simulated."""
    recording: Recording = result.recordings[index]
    inputs = [name for name in result.inputs if name in recording.names]
    rows = len(inputs) + len(result.outputs)
    figure = Figure(figsize=(9, 1.2 + 1.7 * rows), layout="constrained")
    axes = np.atleast_1d(figure.subplots(rows, 1, sharex=True))
    for ax, name in zip(axes, inputs, strict=False):
        ax.plot(recording.time, recording.column(name), color=FORCE, lw=1, label="measured")
        _label(ax, name, recording)
    predicted = result.predicted[index]
    for column, name in enumerate(result.outputs):
        ax = axes[len(inputs) + column]
        measured = recording.column(name)
        ax.plot(recording.time, measured, color=MEASURED, lw=1.6, label="measured")
        ax.plot(
            recording.time, predicted[:, column], color=IDENTIFIED, lw=0.8, label="re-simulated"
        )
        ax.plot(
            recording.time, measured - predicted[:, column], color=GROUND, lw=0.6, label="residual"
        )
        _label(ax, name, recording)
    for ax in axes:
        ax.legend(loc="upper right", ncols=3, fontsize=8, framealpha=0.9)
        ax.margins(x=0)
    axes[-1].set_xlabel("time [s]")
    axes[0].set_title(f"{recording.source}: error {100 * result.nrmse:.2f} % of RMS", fontsize=10)
    return figure


def _label(ax: Axes, name: str, recording: Recording) -> None:
    ax.set_ylabel(f"{name}\n[{unit_of(name, [recording])}]")
    ax.grid(alpha=0.3)


@dataclass(frozen=True)
class Responses:
    """Measured and identified frequency responses, ready to be drawn.

    Attributes:
        measured: by H1; ``shown`` are its lines that are excited and in the band, (lines,).
        shown: which.
        freq: frequencies of the identified ones, every resonance among them [Hz], (points,).
        H: identified, (points, outputs, inputs).
        top_hz: end of the band [Hz].
    """

    measured: FrequencyResponse
    shown: NDArray[np.bool_]
    freq: Array
    H: NDArray[np.complex128]
    top_hz: float


def responses(result: Identification, points: int = 4000) -> Responses:
    """Return frequency responses of an identification, measured and identified."""
    records = [
        (
            np.column_stack(
                [r.column(n) if n in r.names else np.zeros(r.samples) for n in result.inputs]
            ),
            r.matrix(result.outputs),
        )
        for r in result.recordings
    ]
    measured = measured_response(records, result.sampling_hz)
    top = result.fit.w_max / (2 * np.pi) if result.fit else result.sampling_hz / 2
    shown = measured.excited() & (measured.frequency_hz <= 1.1 * top)
    freq = np.linspace(max(measured.frequency_hz[1], top / 1000), top, points)
    # A resonance is narrower than any grid: its peak is put on the grid.
    freq = np.sort(np.concatenate([freq, result.modal.natural_freq]))
    return Responses(measured, shown, freq, identified_response(result, freq), top)


def frequency_responses(result: Identification) -> Figure:
    """Draw measured and identified FRFs, magnitude above phase, one column an input."""
    found = responses(result)
    measured, shown, freq, H, top = found.measured, found.shown, found.freq, found.H, found.top_hz
    count = len(result.inputs)
    figure = Figure(figsize=(5.2 * count + 3.2, 6.2), layout="constrained")
    axes = figure.subplots(
        2, count, sharex=True, squeeze=False, gridspec_kw={"height_ratios": [2, 1]}
    )
    styles = ("-", "--", ":", "-.")
    for j, drive in enumerate(result.inputs):
        upper, lower = axes[0, j], axes[1, j]
        for i, name in enumerate(result.outputs):
            style = styles[i % len(styles)]
            points = measured.H[shown, i, j]
            marker = "os^v"[i % 4]
            dots, curve = measured_and_identified(i, len(result.outputs))
            upper.semilogy(
                measured.frequency_hz[shown], np.abs(points), marker, ms=2.6, color=dots,
                label=f"{name} measured", alpha=0.7,
            )  # fmt: skip
            upper.semilogy(
                freq, np.abs(H[:, i, j]), style, lw=1.2, color=curve,
                label=f"{name} identified",
            )  # fmt: skip
            lower.plot(
                measured.frequency_hz[shown], np.degrees(np.angle(points)), marker, ms=2,
                color=dots, alpha=0.7,
            )  # fmt: skip
            lower.plot(freq, np.degrees(np.angle(H[:, i, j])), style, lw=0.9, color=curve)
        above, below = (unit_of(n, result.recordings) for n in (result.outputs[0], drive))
        unit = f"({above})/({below})".replace("(N)", "N")
        upper.set_title(f"input {drive}, {measured.method}", fontsize=9)
        upper.set_ylabel(f"magnitude [{unit}]")
        lower.set_ylabel("phase [°]")
        lower.set_yticks([-180, -90, 0, 90, 180])
        lower.set_xlabel("frequency [Hz]")
        upper.legend(fontsize=8, loc="best")
        for ax in (upper, lower):
            ax.grid(alpha=0.3)
            ax.set_xlim(0, top)
    return figure


def singular_values(result: Identification) -> Figure:
    """Draw the singular values of the Hankel matrix and the order that was chosen (Fig. 7)."""
    sigma = result.singular_values[:SHOWN_SINGULAR_VALUES]
    if not len(sigma):
        return _empty("no Hankel matrix was needed")
    number = np.arange(1, len(sigma) + 1)
    figure = Figure(figsize=(6.4, 4), layout="constrained")
    ax = figure.subplots()
    kept = number <= result.order
    positive = np.maximum(sigma, sigma[0] * 1e-17)
    ax.semilogy(number[kept], positive[kept], "o", color=IDENTIFIED, label="kept")
    ax.semilogy(number[~kept], positive[~kept], "o", color=REJECTED, label="left out")
    ax.axvline(result.order + 0.5, color=GROUND, lw=0.8, ls="--")
    ax.set_xlabel("number")
    ax.set_ylabel("singular value of the Hankel matrix")
    ax.set_title(f"order {result.order}", fontsize=10)
    ax.grid(alpha=0.3)
    ax.legend()
    return figure


def _empty(text: str) -> Figure:
    figure = Figure(figsize=(6.4, 1.2), layout="constrained")
    ax = figure.subplots()
    ax.axis("off")
    ax.text(0.5, 0.5, text, ha="center", va="center")
    return figure


def stabilisation_diagram(result: Identification) -> Figure:
    """Draw the poles of every order over the measured responses, and the identified modes."""
    figure = Figure(figsize=(8, 4.6), layout="constrained")
    top = result.fit.w_max / (2 * np.pi) if result.fit else result.sampling_hz / 2
    draw_poles(figure, diagram_of(result), result.modal.natural_freq, top)
    return figure


def diagram_of(result: Identification) -> PoleDiagram:
    """Return an identification's stabilisation diagram over its measured responses."""
    found = responses(result, 2)
    shown = found.measured
    return of_responses(result.diagram, shown.frequency_hz[found.shown], shown.H[found.shown])


def modes(result: Identification) -> Figure:
    """Draw the mode shapes as deflections of the frame."""
    shapes = mode_shapes(result.modal)
    figure = Figure(figsize=(max(2.6 * len(shapes), 4), 4.6), layout="constrained")
    axes = np.atleast_1d(figure.subplots(1, len(shapes), sharey=True))
    for ax, mode in zip(axes, shapes, strict=True):
        still = np.zeros(len(mode.places))
        moved = 0.12 * np.real(mode.shape)
        for x, colour, width in ((still, REJECTED, 0.8), (moved, IDENTIFIED, 2.0)):
            for level in range(len(x)):
                line = np.array([x[level] - HALF_SPAN, x[level] + HALF_SPAN])
                ax.plot(line, [HEIGHT * level] * 2, color=colour, lw=2 * width)
                for side in (-1, 1):
                    if level:
                        path = beam(x[level - 1], x[level], level - 1, side)
                        ax.plot(path[:, 0], path[:, 1], color=colour, lw=width)
        for level, value in enumerate(mode.shape):
            ax.annotate(
                f"{abs(value):.3f}, {_degrees(value)}°", (0.0, HEIGHT * level + 0.025),
                ha="center", fontsize=8, color="black", zorder=9,
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.0},
            )  # fmt: skip
        ax.set_title(
            f"{mode.frequency_hz:.3f} Hz\n{100 * mode.damping_ratio:.3f} % damping",
            fontsize=10, pad=20,
        )  # fmt: skip
        ax.set_aspect("equal")
        ax.set_xlim(-0.34, 0.34)
        ax.set_xticks([])
        ax.set_yticks([HEIGHT * level for level in range(len(mode.places))], mode.places)
        for spine in ax.spines.values():
            spine.set_visible(False)
    return figure


def _degrees(value: complex) -> int:
    """Return a phase in whole degrees, above -180 and up to 180; of nothing it is zero."""
    turned = round(float(np.degrees(np.angle(value)))) if abs(value) else 0
    return 180 if turned == -180 else turned
