"""Everything there is to look at of a controlled run, as files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from twin.control.absorber import DesignModel
from twin.control.controller import Controller
from twin.control.outcome import Outcome
from twin.control.plant import Plant
from twin.provenance import Provenance
from twin.view import control_figures, figures
from twin.view.control_rrd import write_control_rrd
from twin.view.page.control import write_control_page


def write_control(
    folder: Path,
    outcome: Outcome,
    plant: Plant,
    controller: Controller,
    believed: DesignModel,
    result: Mapping[str, Any],
    made: Provenance | None = None,
) -> list[Path]:
    """Write report, counterparts of Figs. 9 and 10, responses and the Rerun recording, in order.

    Args:
        folder: where they go.
        outcome: the run.
        plant: the truth.
        controller: what closed the loop.
        believed: the model it was designed on.
        result: the figures of the contract.
        made: where the result comes from.
    """
    linear = plant.linear()
    return [
        write_control_page(folder / "control.html", result, outcome, controller, linear, made),
        figures.save(control_figures.displacements(outcome), folder / "displacements.png"),
        figures.save(control_figures.effort(outcome), folder / "effort.png"),
        figures.save(
            control_figures.responses(controller, linear, plant.delay),
            folder / "responses.png",
        ),
        write_control_rrd(folder / "control.rrd", outcome, plant, controller, believed),
    ]
