"""Figures of a recording and of a twin's modes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twin.recording import Recording
from twin.view.colours import FORCE, MEASURED
from twin.view.deflection import ModeShape
from twin.view.shown import Figure


def samples(recording: Recording) -> Figure:
    """Draw every channel over time, inputs first."""
    names = (*recording.inputs, *recording.outputs) or recording.names
    figure = Figure(figsize=(9, 1.0 + 1.6 * len(names)), layout="constrained")
    axes = np.atleast_1d(figure.subplots(len(names), 1, sharex=True))
    for ax, name in zip(axes, names, strict=True):
        colour = FORCE if name in recording.inputs else MEASURED
        ax.plot(recording.time, recording.column(name), color=colour, lw=0.9)
        ax.set_ylabel(f"{name}\n[{recording.channel(name).unit}]", parse_math=False)
        ax.grid(alpha=0.3)
    axes[-1].set_xlabel("time [s]")
    axes[0].set_title(recording.source, fontsize=10, parse_math=False)
    return figure


def shapes(modes: Sequence[ModeShape]) -> Figure:
    """Draw what each mode does to each place, the largest motion being one."""
    figure = Figure(figsize=(max(2.4 * len(modes), 4), 3.6), layout="constrained")
    axes = np.atleast_1d(figure.subplots(1, max(len(modes), 1), sharey=True))
    for ax, mode in zip(axes, modes, strict=False):
        real = np.real(mode.shape)
        level = np.arange(len(real))
        ax.plot(real, level, "o-", color=MEASURED)
        ax.axvline(0, color="0.6", lw=0.8)
        ax.set_yticks(level, mode.places, fontsize=8)
        ax.set_title(f"{mode.frequency_hz:.3f} Hz, {100 * mode.damping_ratio:.2f} %", fontsize=9)
        ax.set_xlim(-1.15, 1.15)
        ax.grid(alpha=0.3)
    return figure
