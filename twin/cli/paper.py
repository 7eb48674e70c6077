"""``twin paper``: the paper's numbers, recomputed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from io import StringIO
from typing import TYPE_CHECKING, Any

import typer
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from twin.cli.common import (
    Json,
    Out,
    Seed,
    check_folder,
    check_json_target,
    console,
    write_json,
    write_whole,
)

if TYPE_CHECKING:
    from twin.paper import Contradiction, Entry

FILE_WIDTH = 100

STYLE = {
    "agrees": "green",
    "consistent": "green",
    "holds": "green",
    "cut off": "yellow",
    "open": "yellow",
    "contradicts": "red",
}


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command(epilog="Example: twin paper --json - | jq '.contradictions[].title'")
    def paper(out: Out = None, seed: Seed = 0, json: Json = None) -> None:
        """Recompute every number the paper prints and list what contradicts what.

        Printed and recomputed numbers stand side by side; each contradiction follows with its
        derivation. With --out, DIR gets ledger.txt and ledger.json. The seed is that of the noise
        in the simulation behind (60).
        """
        from twin.paper import contradictions, ledger

        check_json_target(json)
        if out is not None:
            check_folder(out)
        entries, found = ledger(seed), contradictions()
        result = as_dict(entries, found)
        show(console(json), entries, found)
        if out is not None:
            buffer = StringIO()
            page = Console(file=buffer, width=FILE_WIDTH, highlight=False)
            show(page, entries, found)
            text = buffer.getvalue()
            write_whole(out / "ledger.txt", lambda part: part.write_text(text, encoding="utf-8"))
            write_json(result, str(out / "ledger.json"))
        write_json(result, json)


def as_dict(entries: tuple[Entry, ...], found: tuple[Contradiction, ...]) -> dict[str, Any]:
    """Return the ledger as plain types for JSON."""
    return {
        "entries": [entry.to_dict() for entry in entries],
        "contradictions": [contradiction.to_dict() for contradiction in found],
        "verdicts": dict(Counter(entry.verdict for entry in entries)),
    }


def show(screen: Console, entries: tuple[Entry, ...], found: tuple[Contradiction, ...]) -> None:
    """Print the table, its notes and the contradictions."""
    for part in (_table(entries), _legend(entries), _notes(entries), "", _contradictions(found)):
        screen.print(part)
    counts = Counter(entry.verdict for entry in entries)
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in counts.most_common())
    screen.print(f"{len(entries)} lines: {verdicts}. {len(found)} contradictions.")


def _table(entries: tuple[Entry, ...]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for name in ("Eq.", "Quantity", "Printed", "Ours", "Ours from", "Verdict", "See"):
        right = name in ("Printed", "Ours")
        table.add_column(name, justify="right" if right else "left", overflow="fold")
    before = None
    for entry in entries:
        equation = entry.equation if entry.equation != before else ""
        before = entry.equation
        quantity = f"{entry.quantity} [{entry.unit}]" if entry.unit else entry.quantity
        cells = (equation, quantity, entry.printed, entry.ours, entry.route)
        table.add_row(
            *(Text(cell) for cell in cells),
            Text(entry.verdict, style=STYLE.get(entry.verdict, "")),
            Text(" ".join(entry.contradictions)),
        )
    return table


def _listed(rows: Iterable[tuple[str, Text]]) -> Table:
    """Return a list whose texts hang beside their labels."""
    grid = Table.grid(padding=(0, 2, 0, 0))
    grid.add_column(no_wrap=True)
    grid.add_column()
    for label, text in rows:
        grid.add_row(Text(label, style="bold"), text)
    return grid


def _legend(entries: tuple[Entry, ...]) -> Text:
    from twin.paper.entry import VERDICTS

    used = {entry.verdict for entry in entries}
    meanings = (f"{name}: {text}" for name, text in VERDICTS.items() if name in used)
    return Text(f"{'; '.join(meanings)}.\n", style="dim")


def _notes(entries: tuple[Entry, ...]) -> Table:
    notes = {entry.note: entry for entry in reversed(entries) if entry.note}
    return _listed(
        (entry.equation, Text(f"{entry.quantity}, {entry.route}: {note}.", style="dim"))
        for note, entry in reversed(notes.items())
    )


def _contradictions(found: tuple[Contradiction, ...]) -> Table:
    return _listed(
        (
            contradiction.id,
            Text.assemble(
                (contradiction.title, "bold"),
                "\n",
                (", ".join(contradiction.equations), "dim"),
                f"\n{contradiction.derivation}\n",
            ),
        )
        for contradiction in found
    )
