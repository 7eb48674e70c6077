"""Generate all, write the manifest, diagnose blind, then open and score; resumable throughout."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import Any

from twin.campaign import campaign
from twin.errors import TwinError, available
from twin.files import write_whole

from .case import case_name
from .kept import mend, read_kept, sweep
from .pictures import draw_confusion
from .seal import write_manifest
from .steps import (
    Blind,
    Concealing,
    Diagnose,
    Opening,
    conceal,
    diagnose_blind,
    of_the_command,
    open_and_score,
)
from .summary import summarise
from .tables import KNOWN
from .versions import versions

__all__ = ["run"]

Told = Callable[[str, int, int], None]


def run(
    tables: Mapping[str, int],
    seed: int,
    out: Path,
    executor: Executor | None = None,
    progress: Told | None = None,
    diagnose: Diagnose | None = None,
    budget_s: float = float("inf"),
) -> dict[str, dict[str, Any]]:
    """Run a campaign; what the folder already holds is not done again.

    Every truth is written and its SHA-256 is in the manifest before the first diagnosis starts,
    and no seal is opened before the diagnosis of its case is stored.

    Args:
        tables: how many cases of each table.
        seed: of everything that is drawn; no diagnosis is told.
        out: gets recordings/, sealed/, diagnoses/, results.jsonl, summary.json, confusion.png.
        executor: where it runs; None is here, one after the other.
        progress: told the step's name, how many are done, of how many.
        diagnose: a function of a module; None is that of ``twin diagnose``.
        budget_s: no diagnosis is started after so many seconds; what is diagnosed is scored.

    Returns:
        By case, of those that are diagnosed: truth, diagnosis, reference (of the true model) and
        score.

    Raises:
        TwinError: an unknown table, or a folder that holds another campaign or a broken seal.
    """
    until = time.time() + budget_s
    for table in tables:
        if table not in KNOWN:
            raise TwinError(f"no table '{table}' of concealed cases; there are {available(KNOWN)}")
    if diagnose is None:
        of_the_command()  # that there is none, is said before anything is generated
    out = out.resolve()
    sealed, recordings, diagnoses = out / "sealed", out / "recordings", out / "diagnoses"
    cases = _mixed(tables)
    for folder in (out, sealed, diagnoses):
        sweep(folder)
    tasks = {
        name: Concealing(table, number, seed, recordings, sealed)
        for name, (table, number) in cases.items()
    }
    drawn = _kept(conceal, tasks, executor, sealed / "digests.jsonl", seed, progress, "generated")
    made_with = versions()
    digests = {name: entry["sha256"] for name, entry in drawn.items()}
    manifest = write_manifest(sealed, digests, _command(tables, seed), made_with)

    refused = (sealed, out / "results.jsonl", out / "summary.json")
    waiting = {
        name: Blind(
            recordings / name, drawn[name]["model"], diagnoses / f"{name}.json", refused, until,
            made_with, diagnose,
        )
        for name in cases
        if read_kept(diagnoses / f"{name}.json") is None
    }  # fmt: skip
    ready = len(cases) - len(waiting)
    told = _after(progress, "diagnosed", ready, len(cases)) if progress is not None else None
    campaign(diagnose_blind, waiting, executor, progress=told)

    stored = {name: diagnoses / f"{name}.json" for name in _in_order(cases)}
    opened = {
        name: Opening(sealed / f"{name}.json", manifest["sha256"][name], recordings, path)
        for name, path in stored.items()
        if path.exists()
    }
    results = _kept(
        open_and_score, opened, executor, out / "results.jsonl", seed, progress, "opened"
    )
    summary = summarise(results)
    text = json.dumps(summary, indent=1, allow_nan=False) + "\n"
    write_whole(out / "summary.json", lambda part: part.write_text(text))
    draw_confusion(summary["confusion"], out / "confusion.png")
    return results


def _kept(
    work: Callable[[Any], dict[str, Any]], tasks: Mapping[str, Any], executor: Executor | None,
    file: Path, seed: int, progress: Told | None, step: str,
) -> dict[str, dict[str, Any]]:  # fmt: skip
    mend(file)
    told = partial(progress, step) if progress is not None else None
    return campaign(work, tasks, executor, file, f"concealed cases of seed {seed}", told)


def _after(progress: Told, step: str, ready: int, total: int) -> Callable[[int, int], None]:
    """Return a report that counts what an earlier run has done."""
    return lambda done, _: progress(step, ready + done, total)


def _mixed(tables: Mapping[str, int]) -> dict[str, tuple[str, int]]:
    """Return (table, number) by the case's name, the tables mixed evenly.

    A campaign that is cut short has then the same share of each.
    """
    every = [
        ((number - 0.5) / count, table, number)
        for table, count in tables.items()
        for number in range(1, count + 1)
    ]
    every.sort(key=lambda entry: entry[0])
    return {case_name(number, table): (table, number) for _, table, number in every}


def _in_order(cases: Mapping[str, tuple[str, int]]) -> list[str]:
    """Return the names, table by table."""
    order = {table: i for i, table in enumerate(KNOWN)}
    return sorted(cases, key=lambda name: (order[cases[name][0]], cases[name][1]))


def _command(tables: Mapping[str, int], seed: int) -> str:
    """Return the command that makes these cases again."""
    counts = {"single": 0, "none": 0, **tables}
    more = [f"--table {name}={n}" for name, n in counts.items() if name not in ("single", "none")]
    words = [f"--cases {counts['single']}", f"--none {counts['none']}", *more, f"--seed {seed}"]
    return "twin concealed " + " ".join(words)
