"""A diagnosis in the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from twin.diagnosis.result import Diagnosis
from twin.view.diagnosis_words import (
    FINDING_HEADERS,
    FIT_HEADERS,
    finding_rows,
    fit_rows,
    proof_sentence,
    verdict_sentence,
)

SHOWN = 4
"""Alternatives that are printed; the report has all."""


def print_diagnosis(console: Console, diagnosis: Diagnosis) -> None:
    """Print verdict, findings, what else is possible, errors, advice and notes."""
    console.print(escape(verdict_sentence(diagnosis)), style="bold")
    console.print(escape(proof_sentence(diagnosis)))
    if diagnosis.findings:
        console.print(_table("Findings", FINDING_HEADERS, finding_rows(diagnosis.findings)))
    if diagnosis.alternatives:
        rows = finding_rows(diagnosis.alternatives[:SHOWN])
        console.print(_table("Also looked at", FINDING_HEADERS, rows))
    console.print(_table("Errors (NRMSE)", FIT_HEADERS, fit_rows(diagnosis)))
    if diagnosis.next_experiment is not None:
        console.print(f"next experiment: {escape(diagnosis.next_experiment.reason)}")
        console.print(f"  {escape(diagnosis.next_experiment.command)}", soft_wrap=True)
    for note in diagnosis.notes:
        console.print(f"note: {escape(note)}", style="dim")


def _table(title: str, headers: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    table = Table(title=title, title_justify="left")
    for header in headers:
        table.add_column(header)
    for row in rows:
        table.add_row(*(escape(cell) for cell in row))
    return table
