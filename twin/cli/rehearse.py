"""``twin rehearse``: what a planned test would find on a twin, at which size, and as what."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

from twin.cli.common import Json, Out, Seed, check_folder, check_json_target, console, write_json
from twin.cli.executors import Scheduler, Workers, executor_of

if TYPE_CHECKING:
    from twin.rehearsal.result import Rehearsal

DEFAULT_FOLDER = Path("twin-rehearsal")
RESULT = "rehearsal.json"


def register(app: typer.Typer) -> None:
    """Add the command."""
    example = "Example: `twin rehearse portal_3d --plan plan.toml --verify 2 --out rehearsed`"
    app.command("rehearse", epilog=example)(rehearse)


def rehearse(
    model: Annotated[str, typer.Argument(help="MJCF file, or a shipped model's name.")],
    plan: Annotated[
        Path,
        typer.Option(
            "--plan", metavar="FILE",
            help="Recordings, sensors, noise and what is concealed, as TOML or JSON.",
        ),
    ],
    verify: Annotated[
        int,
        typer.Option(
            "--verify", min=0, max=20, metavar="N",
            help="Diagnoses of each effect, at most; 0 only predicts.",
        ),
    ] = 0,
    workers: Workers = 0,
    scheduler: Scheduler = None,
    out: Out = None,
    seed: Seed = 0,
    json: Json = None,
) -> None:  # fmt: skip
    """Say what a planned test would find, at which size, and what it would be mistaken for.

    Effects are concealed in your own twin and recorded with your own sensors, noise and tests. The
    size from which each is found is predicted from the Fisher information of the recordings. With
    --verify it is then tried by whole diagnoses, doubled where the effect was not named first, and
    taken as verified after two successes in a row or the last of the diagnoses. The folder of
    --out (twin-rehearsal) keeps them: run the command again to go on, with a larger N, too.
    """
    check_json_target(json)
    from twin.rehearsal.plan import read_plan
    from twin.rehearsal.rehearse import rehearse as whole

    planned = read_plan(plan)
    target = check_folder(out or DEFAULT_FOLDER)
    terminal, shown = console(json), Console(stderr=True)
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
        TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(
        *columns, console=shown, transient=True, disable=not shown.is_terminal
    ) as bar:  # fmt: skip
        bars: dict[str, TaskID] = {}

        def report(step: str, done: int, of: int) -> None:
            if step not in bars:
                bars[step] = bar.add_task(step, total=of)
            bar.update(bars[step], completed=done, total=of)

        def tell(predicted: Rehearsal) -> None:
            show(terminal, predicted, "predicted")

        if verify:
            with executor_of(workers, scheduler) as executor:
                found = whole(
                    model, planned, verify=verify, executor=executor, folder=target, seed=seed,
                    report=report, tell=tell,
                )  # fmt: skip
        else:
            found = whole(model, planned, folder=target, seed=seed, report=report)
    show(terminal, found, "verified by diagnoses" if verify else "predicted; --verify 2 tries them")
    found.save(target / RESULT)
    terminal.print(f"written: {target / RESULT}")
    write_json(found.to_dict(), json)


def show(terminal: Console, found: Rehearsal, how: str) -> None:
    """Print the limits as a table, grouped by mechanism."""
    from twin.rehearsal.result import WORDS

    title = f"What {found.recordings} recordings of {found.source} would find: {how}"
    table = Table(title=title)
    for name in ("mechanism", "place", "from", "share", "rests on", "below that taken for"):
        table.add_column(name, no_wrap=True)
    for limit in found.limits:
        words = WORDS[limit.status]
        if limit.tries:
            words += f", {sum(t.found for t in limit.tries)} of {len(limit.tries)} found"
        row: Sequence[str] = (
            limit.mechanism, limit.place, limit.in_words, limit.share_in_words, words,
            limit.mistaken_for,
        )  # fmt: skip
        table.add_row(*row)
    terminal.print(table)
