"""Closure: a twin that has a mechanism is consistent with itself, one that lacks it gets it named.

For plain models and for every mechanism of the vocabulary, on a chain, a portal in space and a
cantilever, with virtual recordings of the twin that has it:

1. own: the twin that has it, as a file, is diagnosed: consistent;
2. named: the nominal twin is diagnosed: the first finding is the mechanism, at its place;
3. again: the twin that step 2 wrote is diagnosed with the same recordings: consistent.

What no MJCF can hold (an instrument's fault, a force that nobody measured) has step 2 only.

    python -m experiments.closure --out closure --structure chain --mechanism mass --workers 2

Resumable: the folder keeps what is done. Prints a table.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from experiments.closure_rigs import (
    STRUCTURES,
    Structure,
    linear_of,
    mechanisms_of,
    record,
)
from experiments.closure_sizes import shows, visible
from twin.campaign import campaign
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Mechanism
from twin.model import Twin

PLAIN = "plain"
STEPS = ("own", "named", "again")


@dataclass(frozen=True)
class Task:
    """One row of the table."""

    structure: str
    mechanism: str
    folder: Path


def close(task: Task) -> dict[str, Any]:
    """Do the steps of one row; what fails is told in words.

    Returns:
        place, and by step "right" or what was said instead; "-" for a step that there is not.
    """
    structure = STRUCTURES[task.structure]
    folder = task.folder / f"{task.structure}_{task.mechanism}"
    folder.mkdir(parents=True, exist_ok=True)
    if task.mechanism == PLAIN:
        train, test = record(structure, None, folder)
        answer, _ = _diagnosed(structure.model, train, test, folder / "plain")
        return {"place": "", "own": _quiet(answer), "named": "-", "again": "-"}
    mechanism = visible(structure, task.mechanism)
    done: dict[str, Any] = {"place": mechanism.place, "own": "-", "again": "-"}
    train, test = record(structure, mechanism, folder)
    in_model = not isinstance(mechanism, ChannelFault | Disturbance)
    if in_model:
        own = Twin.load(structure.model).including(mechanism).export(folder / "own.xml")
        answer, _ = _diagnosed(str(own), train, test, folder / "own")
        done["own"] = _quiet(answer)
    answer, twin = _diagnosed(structure.model, train, test, folder / "named")
    done["named"] = _named(answer, mechanism, structure)
    if in_model and twin is not None:
        answer, _ = _diagnosed(twin, train, test, folder / "again")
        done["again"] = _quiet(answer)
    return done


def _diagnosed(
    model: str, train: list[Path], test: list[Path], out: Path
) -> tuple[dict[str, Any], str | None]:
    """Return the JSON of ``twin diagnose`` and the twin that it wrote."""
    diagnose = import_module("twin.cli.diagnose").diagnose_files
    try:
        answer: dict[str, Any] = diagnose(model, train, test, out, 0)
    except Exception as error:  # whatever it is, the row says so
        return {"error": f"{type(error).__name__}: {error}"}, None
    return answer, answer.get("twin")


def _said(answer: Mapping[str, Any]) -> str:
    if "error" in answer:
        return str(answer["error"]).splitlines()[0][:100]
    found = [f"{f['mechanism']} {f['location']}" for f in answer["findings"]]
    return f"{answer['verdict']}: {', '.join(found) or 'nothing'}"


def _quiet(answer: Mapping[str, Any]) -> str:
    quiet = answer.get("verdict") == "consistent" and not answer.get("findings")
    return "right" if quiet else _said(answer)


def _named(answer: Mapping[str, Any], mechanism: Mechanism, structure: Structure) -> str:
    first = next(iter(answer.get("findings", [])), None)
    if first is None or first["mechanism"] != mechanism.name:
        return _said(answer)
    here = _same(first["location"], mechanism.place, structure)
    return "right" if here else _said(answer)


def _same(one: str, other: str, structure: Structure) -> bool:
    """Return whether two places are one: the same name, channels in any order, or a row alike."""
    if sorted(one.split("+")) == sorted(other.split("+")):
        return True
    ports = linear_of(structure).ports
    if one not in ports or other not in ports:
        return False
    a, b = ports[one].row, ports[other].row
    return bool(min(np.linalg.norm(a - b), np.linalg.norm(a + b)) < 1e-6 * np.linalg.norm(b))


def tasks_of(structures: Iterable[str], mechanisms: Iterable[str], out: Path) -> dict[str, Task]:
    """Return the rows by name; no mechanism named means the whole vocabulary."""
    wanted, found = tuple(mechanisms), {}
    for structure in structures:
        rig = STRUCTURES[structure]
        there = [PLAIN, *(name for name in mechanisms_of(rig) if shows(rig, name))]
        for name in there if not wanted else [name for name in wanted if name in there]:
            found[f"{structure} {name}"] = Task(structure, name, out)
    return found


def table(results: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the results as Markdown, with the shares of each step below."""
    lines = ["| structure | mechanism | place | own | named | again |", "|" + "---|" * 6]
    for name, row in results.items():
        structure, mechanism = name.split(" ", 1)
        cells = [structure, mechanism, row["place"], *(row[step] for step in STEPS)]
        lines.append("| " + " | ".join(cells) + " |")
    shares = []
    for step in STEPS:
        asked = [row[step] for row in results.values() if row[step] != "-"]
        shares.append(f"{sum(cell == 'right' for cell in asked)} of {len(asked)}")
    return "\n".join([*lines, "| all | | | " + " | ".join(shares) + " |"])


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("closure"))
    parser.add_argument("--structure", action="append", choices=[*STRUCTURES])
    parser.add_argument("--mechanism", action="append", default=[])
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    rows = tasks_of(given.structure or STRUCTURES, given.mechanism, given.out)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with ProcessPoolExecutor(given.workers, get_context("spawn")) as executor:
        results = campaign(
            close,
            rows,
            executor,
            given.out / "closure.jsonl",
            "closure",
            lambda done, of: print(f"{done} of {of}", flush=True),
        )
    text = table(results)
    (given.out / "closure.md").write_text(text + "\n", encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
