"""``twin identify --model``: the model brought to what was identified, as MJCF."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twin.cli.common import folder
from twin.errors import TwinError

if TYPE_CHECKING:
    from rich.console import Console

    from twin.identification.result import Identification
    from twin.model import Twin


def write_updated(
    twin: Twin, found: Identification, tolerance: float, target: Path, terminal: Console
) -> dict[str, Any]:
    """Write ``updated.xml``, print what changed, and return it for the JSON.

    Args:
        twin: the model.
        found: what was identified.
        tolerance: prior deviation of masses and stiffnesses, as a share.
        target: folder.
        terminal: where to print.
    """
    from rich.table import Table

    from twin.updating import update

    if not tolerance > 0:
        raise TwinError(f"--tolerance {tolerance:g}: a prior deviation is more than nothing")
    try:
        moved = update(twin, found, tolerance)
    except TwinError as error:
        terminal.print(f"note: the model is not updated: {error}", style="dim")
        return {"updated": None}
    table = Table(
        "parameter", "unit", "model", "updated", "std", "prior stds", title="Updated model"
    )
    for column in table.columns:
        column.no_wrap = True
    for c in moved.changes:
        numbers = f"{c.nominal:.5g}", f"{c.updated:.5g}", f"{c.std:.2g}", f"{c.moved:+.2f}"
        table.add_row(f"{c.kind} {c.place}", c.unit, *numbers)
    terminal.print(table)
    for i, j in moved.pairs.items():
        f = (found.modal, i), (moved.before, j), (moved.after, j)
        named = [f"{modal.natural_freq[k]:.6g}" for modal, k in f]
        terminal.print(
            f"mode {i + 1}: identified {named[0]} Hz, model {named[1]}, updated {named[2]}"
        )
    for note in moved.notes:
        bold = note.startswith("warning")
        terminal.print(note if bold else f"note: {note}", style="bold red" if bold else "dim")
    path = moved.twin.export(folder(target) / "updated.xml")
    terminal.print(f"written: {path}")
    return {"updated": {"mjcf": str(path), "changes": [asdict(c) for c in moved.changes]}}
