"""An identification as one HTML file: modes first, then how far they can be believed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from twin.identification.at_sensors import modes_at_sensors
from twin.identification.doubts import WARNING, warnings_and_notes
from twin.identification.pole_diagram import PoleDiagram
from twin.identification.result import Identification
from twin.modal import ModalModel
from twin.model import Twin
from twin.provenance import Provenance, provenance
from twin.view.comparison import (
    Row,
    matrices_of,
    matrix_rows,
    modal_rows,
    mode_rows,
    proportional,
)
from twin.view.diagnosis_words import printable, quantity
from twin.view.figures import diagram_of
from twin.view.page import identification_plots as plots
from twin.view.page.blocks import Block, Items, Page, Section, Table, Text
from twin.view.page.pole_plot import pole_plot
from twin.view.page.render import write_page
from twin.view.tables import BOUND_NOTE, table_columns

NAMED = 4
"""Modes that the first sentence names."""


def write_identification_page(
    path: Path,
    result: Identification,
    truth: Twin | None = None,
    made: Provenance | None = None,
    unseen: Mapping[str, float] | None = None,
) -> Path:
    """Write the report whole or not at all.

    Args:
        path: the .html file.
        result: what was identified.
        truth: the twin the recording was made on, or None.
        made: where it comes from; date and versions alone without.
        unseen: error on each recording that the fit has not seen, share of RMS.
    """
    return write_page(page(result, truth, made or provenance(), unseen or {}), path)


def write_modes_page(
    path: Path,
    modal: ModalModel,
    diagram: PoleDiagram,
    source: str,
    notes: Sequence[str],
    made: Provenance | None = None,
) -> Path:
    """Write a report on modes alone, from frequency responses or outputs, whole or not at all.

    Args:
        path: the .html file.
        modal: the modes.
        diagram: the stabilisation diagram they come from.
        source: what they were found in.
        notes: what a reader has to know.
        made: where it comes from; date and versions alone without.
    """
    made = made or provenance()
    warnings, others = warnings_and_notes(notes)
    doubts = [printable(line.removeprefix(WARNING)) for line in warnings]
    headers, rows = table_columns(mode_rows(modal))
    top = float(diagram.frequency_hz[-1])
    sections = [
        Section("Before you trust what follows", [Items(doubts)] if doubts else []),
        Section("Modes", [Table(headers, rows)]),
        Section("Order", [pole_plot(diagram, modal.natural_freq, top, made.command)]),
        Section("Mode shapes", plots.shapes(modal)),
        Section("Notes", [Items([printable(note) for note in others])]),
    ]
    shown = [s for s in sections if s.blocks]
    return write_page(Page(_title(modal), f"From {printable(source)}.", shown, made), path)


def page(
    result: Identification, truth: Twin | None, made: Provenance, unseen: Mapping[str, float]
) -> Page:
    """Return the report: modes, how well they predict, responses, shapes, matrices."""
    true_modes = modes_at_sensors(truth, result.outputs) if truth else None
    rows = modal_rows(result, true_modes)
    matrices = matrix_rows(result.second_order, matrices_of(truth), result.second_order_std)
    others = [plots.time_histories(result, i) for i in range(1, len(result.recordings))]
    warnings, notes = warnings_and_notes(result.notes)
    doubts = [printable(line.removeprefix(WARNING)) for line in warnings]
    sections = [
        Section("Before you trust what follows", [Items(doubts)] if doubts else []),
        Section("Modes", [Table(*table_columns(rows)), Text(BOUND_NOTE)] if rows else []),
        Section("Measured beside the model", _predicted(result, unseen)),
        Section("Frequency responses", _responses(result, made)),
        Section("Against the truth", _errors((*rows, *matrices))),
        Section("Mode shapes", plots.shapes(result.modal)),
        Section("Masses, stiffnesses, dampings" if result.second_order else "Likeness of the modes",
                _matrices(result, true_modes)),
        Section("All entries", [Table(*table_columns(matrices))] if matrices else [], folded=True),
        Section("Order", [plots.singular_values(result)] if len(result.singular_values) else [],
                folded=True),
        Section("Other recordings", others, folded=True),
        Section("Notes", [Items([result.route, *map(printable, notes)])]),
    ]  # fmt: skip
    return Page(
        _title(result.modal), _lead(result, unseen), [s for s in sections if s.blocks], made
    )


def _title(modal: ModalModel) -> str:
    count = len(modal.natural_freq)
    if not count:
        return "No mode was identified"
    std = modal.natural_freq_std
    named = [
        quantity(float(f), float("nan") if std is None else float(std[i]), "Hz")
        for i, f in enumerate(modal.natural_freq[:NAMED])
    ]
    more = "" if count <= NAMED else f" and {count - NAMED} more"
    return f"{count} mode{'s' * (count > 1)}: {', '.join(named)}{more}"


def _lead(result: Identification, unseen: Mapping[str, float]) -> str:
    files = ", ".join(dict.fromkeys(printable(r.source) for r in result.recordings))
    text = f"From {files}: the model reproduces the outputs to {100 * result.nrmse:.2g} % of RMS"
    if unseen:
        worst = max(unseen.values())
        text += f", recordings that the fit has not seen to {100 * worst:.2g} % or better"
    return f"{text}."


def _predicted(result: Identification, unseen: Mapping[str, float]) -> list[Block]:
    out: list[Block] = [plots.time_histories(result)] if result.recordings else []
    if unseen:
        rows = [(printable(name), f"{100 * error:.2f} %") for name, error in unseen.items()]
        out.append(Table(("recording the fit has not seen", "error, share of RMS"), rows))
    return out


def _responses(result: Identification, made: Provenance) -> list[Block]:
    out: list[Block] = list(plots.frequency_responses(result))
    if result.diagram:
        top = result.fit.w_max / (2 * np.pi) if result.fit else result.sampling_hz / 2
        out.append(pole_plot(diagram_of(result), result.modal.natural_freq, top, made.command))
    return out


def _errors(rows: tuple[Row, ...]) -> list[Block]:
    known = [row for row in rows if row.error_in_std is not None]
    return [plots.parameter_errors(known)] if known else []


def _matrices(result: Identification, true_modes: ModalModel | None) -> list[Block]:
    out: list[Block] = list(plots.matrices(result, true_modes))
    damping = proportional(result)
    if damping is not None:
        out.append(Text("Proportional damping: α = {:.4g} 1/s, β = {:.4g} s.".format(*damping)))
    return out
