"""Figures of a run under control: the counterparts of Figs. 9 and 10, and the loop's responses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from twin.control.absorber import DesignModel
from twin.control.controller import Controller
from twin.control.loop import steady_vibration
from twin.control.outcome import Outcome
from twin.view.colours import FORCE, GROUND, IDENTIFIED, MEASURED, TRUE
from twin.view.shown import Figure

LINES = 3000


def displacements(outcome: Outcome) -> Figure:
    """Draw true and estimated displacement of every floor, control off and on (Fig. 9)."""
    count = len(outcome.floors)
    figure = Figure(figsize=(9, 1 + 2.2 * count), layout="constrained")
    axes = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    for ax, floor, true in zip(axes, outcome.floors, outcome.displacement.T, strict=True):
        ax.plot(outcome.time, 1e3 * true, color=TRUE, lw=1.2, label="true")
        name = f"disp_{floor}"
        if name in outcome.estimates:
            estimated = outcome.estimated[:, outcome.estimates.index(name)]
            ax.plot(
                outcome.sample_time, 1e3 * estimated, ".", color=IDENTIFIED, ms=2,
                label="estimated by the controller",
            )  # fmt: skip
        steady = outcome.reduction.steady[floor]
        ax.set_title(f"{floor}: steady reduction {100 * steady:.1f} %", fontsize=10)
        ax.set_ylabel("displacement [mm]")
        _switch(ax, outcome)
    axes[-1].set_xlabel("time [s]")
    return figure


def effort(outcome: Outcome) -> Figure:
    """Draw torque, swing and excitation (Fig. 10)."""
    figure = Figure(figsize=(9, 6.6), layout="constrained")
    torque, swing, drive = figure.subplots(3, 1, sharex=True)
    torque.step(outcome.sample_time, outcome.torque, where="post", color=FORCE, lw=0.9)
    torque.set_ylabel("torque [N m]")
    torque.set_title(
        f"peak torque {outcome.peak_torque_nm:.3f} N m, peak swing "
        f"{outcome.peak_swing_rad:.3f} rad",
        fontsize=10,
    )
    swing.plot(outcome.time, outcome.angle, color=MEASURED, lw=0.9)
    swing.set_ylabel("swing [rad]")
    drive.plot(outcome.time, outcome.excitation, color=GROUND, lw=0.6)
    unit = "m/s²" if outcome.known_input.startswith("acc") else "N"
    drive.set_ylabel(f"{outcome.known_input}\n[{unit}]")
    drive.set_xlabel("time [s]")
    for ax in (torque, swing, drive):
        _switch(ax, outcome, legend=False)
    return figure


def responses(controller: Controller, plant: DesignModel, delay: int) -> Figure:
    """Draw each floor's steady vibration for a unit harmonic input, without and with control.

    Args:
        controller: at full gain.
        plant: the linearised plant.
        delay: whole samples between reading and acting.
    """
    top = 0.5 / controller.dt
    freq = np.geomspace(top / 200, 0.98 * top, LINES)
    free = steady_vibration(None, plant, freq, delay, controller.dt)
    held = steady_vibration(controller, plant, freq, delay)
    count = free.displacement.shape[1]
    figure = Figure(figsize=(4.6 * count, 4.2), layout="constrained")
    axes = figure.subplots(1, count, sharey=True, squeeze=False)[0]
    for floor, ax in enumerate(axes):
        for response, colour, label in (
            (free, GROUND, "without control"),
            (held, IDENTIFIED, "with control"),
        ):
            size = 1e3 * np.abs(response.displacement[:, floor])
            ax.loglog(freq, size, color=colour, lw=1.4, label=label)
        ax.set_title(f"floor{floor + 1}", fontsize=10)
        ax.set_xlabel("frequency [Hz]")
        ax.grid(alpha=0.3, which="both")
    unit = "m/s²" if controller.known_input.startswith("acc") else "N"
    axes[0].set_ylabel(f"displacement [mm per {unit}]")
    axes[0].legend()
    return figure


def front(rows: Sequence[Mapping[str, Any]], picked: str, limits: Mapping[str, float]) -> Figure:
    """Draw the front of a search: steady reduction against torque and against swing.

    Args:
        rows: of the front, with name, worst_reduction, worst_torque_nm and worst_swing_rad.
        picked: name of the controller that was picked.
        limits: torque_nm and swing_rad that were set.
    """
    figure = Figure(figsize=(9, 4), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    ordered = sorted(rows, key=lambda row: float(row["worst_reduction"]))
    reduction = [100 * float(row["worst_reduction"]) for row in ordered]
    chosen = next(row for row in ordered if row["name"] == picked)
    for ax, key, limit, label in (
        (axes[0], "worst_torque_nm", limits["torque_nm"], "peak torque [N m]"),
        (axes[1], "worst_swing_rad", limits["swing_rad"], "peak swing [rad]"),
    ):
        effort = [float(row[key]) for row in ordered]
        ax.plot(effort, reduction, "o", color=MEASURED, label="front")
        ax.plot(
            [float(chosen[key])], [100 * float(chosen["worst_reduction"])], "o", ms=11, mfc="none",
            mew=2, color=IDENTIFIED, label=f"picked, trial {picked}",
        )  # fmt: skip
        ax.set_xlabel(f"{label}, limit {limit:g}")
        ax.set_xlim(left=0)
        ax.grid(alpha=0.3)
    axes[0].set_ylabel("steady reduction at the\nless calmed floor [%]")
    axes[0].legend(loc="lower right")
    return figure


def _switch(ax: Axes, outcome: Outcome, legend: bool = True) -> None:
    ax.axvline(outcome.switch_s, color="black", lw=0.9, ls="--", label="control switched on")
    ax.grid(alpha=0.3)
    ax.margins(x=0)
    if legend:
        ax.legend(loc="upper right", fontsize=8, ncols=3, framealpha=0.9)
