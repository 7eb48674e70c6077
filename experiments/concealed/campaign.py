"""Generate, diagnose, open, score: on any executor, resumable from the files it leaves."""

from __future__ import annotations

import json
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from twin.campaign import campaign
from twin.errors import TwinError
from twin.files import write_whole

from .case import case_name, generate
from .reference import reference
from .rig import TWO_STOREY
from .score import score
from .seal import open_seal, write_manifest
from .summary import draw_confusion, summarise

__all__ = ["Task", "generate", "run"]

Diagnose = Callable[..., dict[str, Any]]
"""diagnose(model, train, test, out, seed) -> the JSON of ``twin diagnose``."""

KEPT = ("verdict", "findings", "alternatives", "fit", "fit_ahead", "seconds", "error")
SEEN = ("mechanism", "location", "parameters", "form", "noise", "style", "effect_over_noise")


@dataclass(frozen=True)
class Task:
    """One case of a campaign; the folder must be seen from wherever the work is done."""

    number: int
    nothing: bool
    seed: int
    out: Path
    digest: str = ""
    diagnose: Diagnose | None = None

    @property
    def name(self) -> str:
        """Of the case's folder."""
        return case_name(self.number, self.nothing)


def run(
    cases: int,
    none: int,
    seed: int,
    out: Path,
    executor: Executor | None = None,
    progress: Callable[[str, int, int], None] | None = None,
    diagnose: Diagnose | None = None,
) -> dict[str, dict[str, Any]]:
    """Run a campaign; what the folder already holds is not done again.

    Args:
        cases: how many with one effect concealed.
        none: how many with nothing concealed.
        seed: of everything that is drawn; no diagnosis is told.
        out: gets recordings/, sealed/, diagnoses/, results.jsonl, summary.json, confusion.png.
        executor: where it runs; None is here, one after the other.
        progress: told the step's name, how many are done, of how many.
        diagnose: a function of a module; None is that of ``twin diagnose``.

    Returns:
        By case: truth, diagnosis, reference (of the true model) and score.
    """
    if diagnose is None:
        _of_the_command()  # that there is none, is said before anything is generated
    out = out.resolve()
    asked = [(i + 1, False) for i in range(cases)] + [(i + 1, True) for i in range(none)]
    tasks = {case_name(n, nothing): Task(n, nothing, seed, out) for n, nothing in asked}
    identity = f"concealed cases of seed {seed}"

    def told(step: str) -> Callable[[int, int], None] | None:
        return partial(progress, step) if progress is not None else None

    drawn = campaign(
        conceal, tasks, executor, out / "sealed" / "digests.jsonl", identity, told("generated")
    )
    digests = {name: entry["sha256"] for name, entry in drawn.items()}
    write_manifest(out / "sealed", digests)
    waiting = {
        name: Task(t.number, t.nothing, seed, out, digests[name], diagnose)
        for name, t in tasks.items()
    }
    results = campaign(judge, waiting, executor, out / "results.jsonl", identity, told("diagnosed"))
    summary = summarise(results)
    text = json.dumps(summary, indent=1, allow_nan=False) + "\n"
    write_whole(out / "summary.json", lambda part: part.write_text(text))
    draw_confusion(summary, out / "confusion.png")
    return results


def conceal(task: Task) -> dict[str, Any]:
    """Generate a case and return the SHA-256 of its truth."""
    digest = generate(
        task.number, task.seed, task.out / "recordings", task.out / "sealed", task.nothing
    )
    return {"sha256": digest}


def judge(task: Task) -> dict[str, Any]:
    """Diagnose a case, then open its seal and score; a diagnosis that fails is a miss."""
    diagnosis = _diagnosed(task)
    text = json.dumps(diagnosis, indent=1) + "\n"
    write_whole(task.out / "diagnoses" / f"{task.name}.json", lambda part: part.write_text(text))
    truth = open_seal(task.out / "sealed" / f"{task.name}.json", task.digest)
    reached = reference(truth, task.out / "recordings")
    return {
        "truth": {key: truth[key] for key in SEEN},
        "diagnosis": {key: diagnosis[key] for key in KEPT if key in diagnosis},
        "reference": reached,
        "score": score(truth, diagnosis, reached),
    }


def _diagnosed(task: Task) -> dict[str, Any]:
    folder = task.out / "recordings" / task.name
    train = [folder / f"train_{i}.csv" for i in range(1, 5)]
    test = [folder / f"test_{i}.csv" for i in range(1, 3)]
    diagnose = task.diagnose or _of_the_command()
    try:
        return diagnose(TWO_STOREY.model, train, test, None, 0)
    except Exception as error:
        return {"error": f"{type(error).__name__}: {error}"}


def _of_the_command() -> Diagnose:
    try:
        module = import_module("twin.cli.diagnose")
    except ImportError as error:
        raise TwinError(f"there is no diagnosis to test ({error})") from None
    found: Diagnose = module.diagnose_files
    return found
