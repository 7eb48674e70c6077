"""A controlled run as one HTML file: what it gains, what it costs, and why."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from twin.control.absorber import DesignModel
from twin.control.controller import Controller
from twin.control.loop import steady_vibration
from twin.control.outcome import Outcome
from twin.provenance import Provenance, provenance
from twin.view.colours import FORCE, GROUND, IDENTIFIED, MEASURED, TRUE
from twin.view.control_figures import LINES
from twin.view.page.blocks import Block, Items, Page, Plot, Section, Table, Text
from twin.view.page.plots import Panel, figure, line, points
from twin.view.page.render import write_page
from twin.view.tables import REDUCTIONS

MARGIN_NOTE = (
    "The stability margin is the distance of the loop's Nyquist curve from -1; the step is what "
    "one sample costs this computer."
)


def write_control_page(
    path: Path,
    result: Mapping[str, Any],
    outcome: Outcome,
    controller: Controller,
    plant: DesignModel,
    made: Provenance | None = None,
) -> Path:
    """Write the report whole or not at all.

    Args:
        path: the .html file.
        result: the figures of the contract, with those of the true model under "with_true_model".
        outcome: the run with the controller that was designed on the identified model.
        controller: that controller.
        plant: the true plant, linear.
        made: where it comes from; date and versions alone without.
    """
    return write_page(page(result, outcome, controller, plant, made or provenance()), path)


def page(
    result: Mapping[str, Any], outcome: Outcome, controller: Controller, plant: DesignModel,
    made: Provenance,
) -> Page:  # fmt: skip
    """Return the report: reductions, the run, its effort, the responses."""
    notes: list[Block] = [Items(list(result["notes"]))] if result["notes"] else []
    sections = [
        Section("What it gains and costs", [_figures(result), Text(MARGIN_NOTE)]),
        Section("The run", [_displacements(outcome), _effort(outcome)]),
        Section("Steady vibration by frequency", _responses(result, controller, plant)),
        Section("Notes", notes),
    ]
    reductions = result["reduction"]["steady"]
    each = (f"{name} by {100 * share:.0f}\u00a0%" for name, share in reductions.items())
    listed = " and ".join(each)
    title = f"Control reduces the steady vibration of {listed}"
    lead = (
        f"Excited by {result['excitation']}; peak torque {result['peak_torque_nm']:.3g} N m, peak "
        f"swing {result['peak_swing_rad']:.3g} rad, "
        f"stability margin {result['stability_margin']:.3g}."
    )
    return Page(title, lead, [section for section in sections if section.blocks], made)


def _figures(result: Mapping[str, Any]) -> Table:
    true = result["with_true_model"]
    rows = [
        (f"{REDUCTIONS[window]}, {floor}", f"{100 * share:.1f} %",
         f"{100 * true['reduction'][window][floor]:.1f} %")
        for window, floors in result["reduction"].items()
        for floor, share in floors.items()
    ]  # fmt: skip
    for name, key in (
        ("peak swing [rad]", "peak_swing_rad"),
        ("peak torque [N m]", "peak_torque_nm"),
        ("stability margin", "stability_margin"),
    ):
        rows.append((name, f"{result[key]:.3f}", f"{true[key]:.3f}"))
    median = (f"{r['controller_step_us']['median']:.1f}" for r in (result, true))
    rows.append(("controller step, median [µs]", next(median), next(median)))
    return Table(("", "designed on the identified model", "on the true model"), rows)


def _displacements(outcome: Outcome) -> Plot:
    panels = []
    for floor, true in zip(outcome.floors, outcome.displacement.T, strict=True):
        drawn = [line(outcome.time, 1e3 * true, "true", TRUE, 1.2)]
        name = f"disp_{floor}"
        if name in outcome.estimates:
            guess = 1e3 * outcome.estimated[:, outcome.estimates.index(name)]
            drawn.append(points(outcome.sample_time, guess, "estimated", IDENTIFIED, 2.5))
        gain = outcome.reduction.steady[floor]
        title = f"<b>{floor}</b> [mm]: steady reduction {100 * gain:.1f} %"
        panels.append(Panel(title, drawn))
    ends = (0.0, float(outcome.time[-1]))
    plot = figure(panels, "time [s]", ends, hover="x", verticals=[(outcome.switch_s, "#000000")])
    caption = "Displacements; the dotted line is where control is switched on."
    return Plot(plot, caption, [("true", TRUE), ("estimated", IDENTIFIED)], "time")


def _effort(outcome: Outcome) -> Plot:
    unit = "m/s²" if outcome.known_input.startswith("acc") else "N"
    panels = [
        Panel("<b>torque</b> [N m]", [line(outcome.sample_time, outcome.torque, "torque", FORCE)]),
        Panel("<b>swing</b> [rad]", [line(outcome.time, outcome.angle, "swing", MEASURED)]),
        Panel(f"<b>{outcome.known_input}</b> [{unit}]",
              [line(outcome.time, outcome.excitation, "excitation", GROUND, 0.8)], share=0.7),
    ]  # fmt: skip
    panels[0].traces[0]["line"]["shape"] = "hv"
    ends = (0.0, float(outcome.time[-1]))
    plot = figure(panels, "time [s]", ends, hover="x", verticals=[(outcome.switch_s, "#000000")])
    return Plot(plot, "Torque of the motor, swing of the pendulum, excitation.", (),
                "time")  # fmt: skip


def _responses(
    result: Mapping[str, Any], controller: Controller, plant: DesignModel
) -> list[Block]:
    top = 0.5 / controller.dt
    freq = np.geomspace(top / 200, 0.98 * top, LINES)
    delay = int(result["delay_samples"])
    free = steady_vibration(None, plant, freq, delay, controller.dt)
    held = steady_vibration(controller, plant, freq, delay)
    unit = "m/s²" if controller.known_input.startswith("acc") else "N"
    panels = []
    for number in range(free.displacement.shape[1]):
        drawn = [
            line(freq, 1e3 * np.abs(response.displacement[:, number]), name, colour, 1.6)
            for response, name, colour in (
                (free, "without control", GROUND),
                (held, "with control", IDENTIFIED),
            )
        ]
        panels.append(Panel(f"<b>floor{number + 1}</b> [mm per {unit}]", drawn, log=True))
    ends = (float(np.log10(freq[0])), float(np.log10(freq[-1])))
    keys = [("without control", GROUND), ("with control", IDENTIFIED)]
    ticks = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50]
    plot = figure(panels, "frequency [Hz]", ends, x_log=True, tickvals=ticks,
                  ticktext=[f"{t:g}" for t in ticks])  # fmt: skip
    return [Plot(plot, "For a unit harmonic input, on the linearised true plant.", keys)]
