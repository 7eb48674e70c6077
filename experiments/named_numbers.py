"""Which results hang on which named number of the engine: each is changed alone, by a half.

Every module-level number of ``twin/diagnosis`` and ``twin/estimation`` that is written as such is
multiplied by 1.5 in a copy of the package (whole numbers are rounded, up at least), and a few
cases are diagnosed with that copy, one with nothing concealed and four with one effect. What is
named otherwise than with the number as it stands is printed.

    python -m experiments.named_numbers --out named_numbers --workers 2

Resumable: the folder of --out keeps what is done. --to writes the results as JSON.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from experiments.concealed.case import case_name, generate
from experiments.concealed.steps import TOLERANCE
from experiments.concealed.versions import versions
from twin.campaign import campaign
from twin.files import write_whole

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ("twin/diagnosis", "twin/estimation")
FACTOR = 1.5
SEED = 5200
CASES = (("none", 1), ("single", 1), ("single", 2), ("single", 3), ("single", 4))
"""Table and number of the cases, of the campaign with that seed."""
MODEL = "two_storey_lumped"
AS_IT_STANDS = "as it stands"


@dataclass(frozen=True)
class Number:
    """A number as it is written.

    Attributes:
        file: below the root.
        name: what it is assigned to; several of one line have an index.
        line: from 1.
        start, end: columns of the number in it.
        value: it.
    """

    file: str
    name: str
    line: int
    start: int
    end: int
    value: float

    @property
    def changed(self) -> float:
        """The number to try."""
        if isinstance(self.value, int):
            return max(round(FACTOR * self.value), self.value + 1)
        return FACTOR * self.value


@dataclass(frozen=True)
class Task:
    """Cases that are diagnosed with one number changed, or none."""

    number: Number | None
    folder: Path


def numbers(root: Path = ROOT) -> list[Number]:
    """Return every named number of the engine that is written as one."""
    out = []
    for folder in FOLDERS:
        for path in sorted((root / folder).glob("*.py")):
            for statement in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(statement, ast.Assign):
                    out += list(_of(statement, str(path.relative_to(root))))
    return out


def _of(statement: ast.Assign, file: str) -> Iterator[Number]:
    names = [n.id for n in ast.walk(statement.targets[0]) if isinstance(n, ast.Name)]
    if not all(name.isupper() for name in names):
        return
    values = [statement.value]
    if len(names) > 1 and isinstance(statement.value, ast.Tuple):
        values = statement.value.elts
    for name, value in zip(names, values, strict=True):
        several = isinstance(value, ast.Tuple)
        for index, part in enumerate(value.elts if isinstance(value, ast.Tuple) else [value]):
            if isinstance(part, ast.Constant) and type(part.value) in (int, float):
                assert part.end_col_offset is not None
                title = f"{name}[{index}]" if several else name
                yield Number(file, title, part.lineno, part.col_offset, part.end_col_offset,
                             part.value)  # type: ignore[arg-type]  # fmt: skip


def with_changed(text: str, number: Number) -> str:
    """Return a file's text with the number changed."""
    lines = text.splitlines(keepends=True)
    line = lines[number.line - 1]
    lines[number.line - 1] = line[: number.start] + repr(number.changed) + line[number.end :]
    return "".join(lines)


def work(task: Task) -> dict[str, Any]:
    """Return what is named in each case; the error where there is one."""
    tree = task.folder / f"tree_{os.getpid()}"
    if not tree.exists():
        for package in ("twin", "experiments", "models"):
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / package, tree / package, ignore=ignored)
    kept, number = tree / "compiled", task.number
    text = ""
    if number is not None:
        changed = tree / number.file
        text = changed.read_text(encoding="utf-8")
        changed.write_text(with_changed(text, number), encoding="utf-8")
        if "numba" in text:  # what calls it is compiled with it
            kept = tree / "compiled_with_change"
            shutil.rmtree(kept, ignore_errors=True)
    try:
        found = subprocess.run(
            [sys.executable, "-m", "experiments.named_numbers", "--diagnose", str(task.folder)],
            cwd=tree, capture_output=True, text=True, check=False,
            env={**os.environ, "PYTHONPATH": str(tree), "NUMBA_CACHE_DIR": str(kept)},
        )  # fmt: skip
    finally:
        if number is not None:
            (tree / number.file).write_text(text, encoding="utf-8")
    if found.returncode:
        return {"error": found.stderr.strip().splitlines()[-1]}
    return {"named": json.loads(found.stdout.splitlines()[-1])}


def named(folder: Path) -> dict[str, list[str]]:
    """Return mechanism and place of the findings of every case in a folder."""
    from twin.diagnosis.pipeline import diagnose
    from twin.formats import read_recording
    from twin.model import Twin

    out = {}
    for table, number in CASES:
        case = case_name(number, table)
        train, test = (
            [
                read_recording(p)
                for p in sorted((folder / "recordings" / case).glob(f"{kind}_*.csv"))
            ]
            for kind in ("train", "test")
        )
        found = diagnose(Twin.load(MODEL), train, test, tolerance=TOLERANCE)
        out[case] = sorted(f"{f.mechanism.name} {f.location}" for f in found.findings)
    return out


def table(results: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the results as Markdown: numbers with which something else is named first."""
    before = results[AS_IT_STANDS]["named"]
    rows, same = [], []
    for name, result in results.items():
        if "error" in result:
            rows.append((name, result["error"]))
            continue
        other = [f"{case}: {_listed(now)} instead of {_listed(before[case])}"
                 for case, now in result["named"].items() if now != before[case]]  # fmt: skip
        if other:
            rows.append((name, "; ".join(other)))
        elif name != AS_IT_STANDS:
            same.append(name)
    lines = ["| number, half as much again | named otherwise |", "|---|---|"]
    lines += [f"| {name} | {what} |" for name, what in rows]
    lines.append(f"\n{len(same)} of {len(results) - 1} numbers change nothing that is named.")
    return "\n".join(lines)


def _listed(found: Sequence[str]) -> str:
    return ", ".join(found) or "nothing"


def tasks(folder: Path, only: Sequence[str]) -> dict[str, Task]:
    """Return the tasks by name: with no number changed, and with each."""
    out = {AS_IT_STANDS: Task(None, folder)}
    for number in numbers():
        name = f"{number.file.removeprefix('twin/')} {number.name}"
        if not only or any(part in name for part in only):
            out[name] = Task(number, folder)
    return out


def main() -> None:
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("named_numbers"))
    parser.add_argument("--only", action="append", help="part of a number's file or name")
    parser.add_argument("--to", type=Path, help="JSON")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--diagnose", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.diagnose:
        print(json.dumps(named(given.diagnose)))
        return
    folder = given.out.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    for kind, number in CASES:
        if not (folder / "recordings" / case_name(number, kind) / "test_2.csv").exists():
            generate(number, SEED, folder / "recordings", folder / "sealed", kind)
    with ProcessPoolExecutor(given.workers, mp_context=get_context("spawn")) as pool:
        results = campaign(work, tasks(folder, given.only or []), pool, folder / "results.jsonl",
                           f"named numbers, seed {SEED}",
                           lambda done, total: print(f"{done} of {total}", flush=True))  # fmt: skip
    if "error" in results[AS_IT_STANDS]:
        raise SystemExit(f"the cases cannot be diagnosed: {results[AS_IT_STANDS]['error']}")
    print(table(results))
    if given.to:
        document = {"made_with": versions(), "seed": SEED, "factor": FACTOR, "results": results}
        text = json.dumps(document, indent=1, allow_nan=False) + "\n"
        write_whole(given.to, lambda part: part.write_text(text))


if __name__ == "__main__":
    main()
