"""Everything there is to look at of a controlled run, as files."""

from __future__ import annotations

from pathlib import Path

from twin.control.absorber import DesignModel
from twin.control.controller import Controller
from twin.control.outcome import Outcome
from twin.control.plant import Plant
from twin.view import control_figures, figures
from twin.view.control_rrd import write_control_rrd


def write_control(
    folder: Path, outcome: Outcome, plant: Plant, controller: Controller, believed: DesignModel
) -> list[Path]:
    """Write the counterparts of Figs. 9 and 10, the responses and the Rerun recording."""
    return [
        figures.save(control_figures.displacements(outcome), folder / "displacements.png"),
        figures.save(control_figures.effort(outcome), folder / "effort.png"),
        figures.save(
            control_figures.responses(controller, plant.linear(), plant.delay),
            folder / "responses.png",
        ),
        write_control_rrd(folder / "control.rrd", outcome, plant, controller, believed),
    ]
