"""An identification for people: tables in the terminal, figures and a Rerun recording in files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console

from twin.identification.at_sensors import modes_at_sensors
from twin.identification.doubts import warnings_and_notes
from twin.identification.from_responses import ResponseIdentification
from twin.identification.result import Identification
from twin.laboratory import Performance
from twin.modal import ModalModel
from twin.model import Twin
from twin.provenance import Provenance
from twin.view import figures
from twin.view.comparison import (
    matrices_of,
    matrix_rows,
    modal_rows,
    mode_rows,
    proportional,
)
from twin.view.page.identification import write_identification_page
from twin.view.rrd import write_rrd
from twin.view.tables import channel_table, mode_table, parameter_table

FIGURES = {
    "time_histories": figures.time_histories,
    "frequency_responses": figures.frequency_responses,
    "singular_values": figures.singular_values,
    "stabilisation": figures.stabilisation_diagram,
    "mode_shapes": figures.modes,
}


def print_identification(
    console: Console,
    result: Identification,
    truth: Twin | None,
    unseen: Mapping[str, float] | None = None,
) -> None:
    """Print channels, warnings, identified beside true parameters, errors and notes."""
    for recording in result.recordings:
        console.print(channel_table(recording))
    warnings, notes = warnings_and_notes(result.notes)
    _print_warnings(console, warnings)
    rows = modal_rows(result, modes_at_sensors(truth, result.outputs) if truth else None)
    console.print(mode_table(rows, "Modes"))
    matrices = matrix_rows(result.second_order, matrices_of(truth), result.second_order_std)
    if matrices:
        console.print(parameter_table(matrices, "Mass and stiffness, eq. (41)"))
    damping = proportional(result)
    if damping is not None:
        console.print("proportional damping: alpha = {:.4g} 1/s, beta = {:.4g} s".format(*damping))
    console.print(f"estimate: {result.route}")
    console.print(f"error of the re-simulated outputs: {100 * result.nrmse:.2f} % of their RMS")
    for name, error in (unseen or {}).items():
        console.print(f"error on {name}, not seen by the fit: {100 * error:.2f} % of RMS")
    for note in notes:
        console.print(f"note: {note}", style="dim")


def _print_warnings(console: Console, warnings: Sequence[str]) -> None:
    """Print each in a line of its own, however narrow the terminal."""
    for line in warnings:
        console.print(line, style="bold red", soft_wrap=True)


def print_responses(console: Console, result: ResponseIdentification) -> None:
    """Print the modes found in frequency responses, warnings first."""
    error = f"error of the modelled responses: {100 * result.error:.2f} % of their RMS"
    print_modes(console, result.modal, result.responses.source, result.notes, error)


def print_modes(
    console: Console, modal: ModalModel, source: str, notes: Sequence[str], more: str = ""
) -> None:
    """Print modes alone, warnings first.

    Args:
        console: where to.
        modal: the modes.
        source: what they were found in.
        notes: warnings and others.
        more: a line to follow the table.
    """
    warnings, others = warnings_and_notes(notes)
    _print_warnings(console, warnings)
    console.print(mode_table(mode_rows(modal), f"Modes in {source}"))
    if more:
        console.print(more)
    for note in others:
        console.print(f"note: {note}", style="dim")


def write_identification(
    folder: Path,
    result: Identification,
    truth: Twin | None = None,
    performance: Performance | None = None,
    made: Provenance | None = None,
    unseen: Mapping[str, float] | None = None,
) -> list[Path]:
    """Write the report, every figure and the Rerun recording into ``folder``; return their paths.

    Args:
        folder: where they go.
        result: what was identified.
        truth: the twin the recording was made on, or None.
        performance: the virtual test, whose motion is shown, or None.
        made: where the result comes from.
        unseen: error on each recording that the fit has not seen, share of RMS.
    """
    page = folder / "identification.html"
    files = [write_identification_page(page, result, truth, made, unseen)]
    files += [figures.save(draw(result), folder / f"{n}.png") for n, draw in FIGURES.items()]
    files.append(write_rrd(folder / "identification.rrd", result, truth, performance))
    return files
