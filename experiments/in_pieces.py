"""Experiments that are run in pieces: a folder keeps what is done, and one version does it all."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from experiments.concealed.versions import versions
from twin.campaign import campaign
from twin.errors import TwinError
from twin.files import folder, write_whole

RESULTS = Path(__file__).resolve().parent / "results"


class Named(Protocol):
    """A task whose name holds all that decides its result."""

    @property
    def name(self) -> str:
        """All that decides the result."""
        ...


@dataclass(frozen=True)
class Pieces:
    """A folder with what is done, and the means to go on.

    Attributes:
        title: of the results; a folder with others is refused.
        folder: that keeps the results as they come.
        results: where the document is written.
        made_with: the versions that the results were begun with.
        executor: does the tasks; None does them here.
        workers: of the executor.
        until: when no further task is begun [Unix s].
    """

    title: str
    folder: Path
    results: Path
    made_with: Mapping[str, str]
    executor: Executor | None
    workers: int
    until: float

    def done(
        self, work: Callable[[Any], dict[str, Any]], every: Sequence[Named], name: str,
        cut_short: bool = True,
    ) -> list[dict[str, Any]]:  # fmt: skip
        """Do what the folder does not hold yet, until the time is up; return all it holds."""
        file = self.folder / f"{name}.jsonl"
        held = _read(file)
        waiting = [task for task in every if task.name not in held]
        for first in range(0, len(waiting), 4 * self.workers):
            if cut_short and time.time() > self.until:
                break
            some = {task.name: task for task in waiting[first : first + 4 * self.workers]}
            campaign(work, some, self.executor, file, self.title)
            left = len(waiting) - first - len(some)
            print(f"{time.strftime('%H:%M:%S')} {name}: {left} to do", flush=True)
        return list(_read(file).values())

    def write(self, found: Mapping[str, Any], name: str) -> Path:
        """Write the document; return its path."""
        text = json.dumps(found, indent=1, allow_nan=False) + "\n"
        return write_whole(self.results / f"{name}.json", lambda part: part.write_text(text))


@contextmanager
def pieces(about: str, title: str) -> Iterator[Pieces]:
    """Read the command line, and open the folder that it names.

    Raises:
        TwinError: the folder was begun with another version, and more is to be done.
    """
    parser = argparse.ArgumentParser(description=about.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--budget", type=float, default=float("inf"), help="minutes")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--results", type=Path, default=RESULTS)
    given = parser.parse_args()
    until = time.time() + 60 * given.budget
    out = folder(given.folder)
    made_with = started_with(out / "made_with.json", given.budget > 0)
    pool = ProcessPoolExecutor(given.workers) if given.workers > 1 else nullcontext()
    with pool as executor:
        yield Pieces(title, out, given.results, made_with, executor, given.workers, until)


def started_with(path: Path, going_on: bool) -> dict[str, str]:
    """Return the versions that the cases were begun with; all are diagnosed with the same.

    Raises:
        TwinError: these are others, and more is to be diagnosed.
    """
    now = versions()
    if not path.exists():
        write_whole(path, lambda part: part.write_text(json.dumps(now) + "\n"))
    begun: dict[str, str] = json.loads(path.read_text())
    if going_on and commit_of(begun) != commit_of(now):
        raise TwinError(
            f"{path}: begun with {begun['commit']}, this is {now['commit']}: the results of two "
            "versions do not mix; use another folder, or --budget 0 to write what is there"
        )
    return begun


def commit_of(made_with: Mapping[str, str]) -> str:
    """Return the commit of some versions."""
    return made_with.get("commit", "").removesuffix("-dirty")


def _read(file: Path) -> dict[str, dict[str, Any]]:
    """Return the results in a file of ``twin.campaign``."""
    if not file.exists():
        return {}
    lines = file.read_text(encoding="utf-8").split("\n")[1:-1]
    return {entry["name"]: entry["result"] for entry in map(json.loads, lines)}
