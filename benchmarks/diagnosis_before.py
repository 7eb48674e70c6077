"""How long a diagnosis takes beside that of an earlier commit, in turns on the same files.

    python benchmarks/diagnosis_before.py --json benchmarks/results/diagnosis_before.json

Needs a clone with its history. Each answer is that of ``twin diagnose``, from files to files, in a
process of its own; before the first one is timed each commit has answered once and is compiled. The
cases are concealed ones (``experiments.concealed``), and a frame of ten storeys with a cubic spring
from the virtual laboratory. What is done is kept in the file of --json: run it again to go on.
"""

# ruff: noqa: E402  (the experiments are beside this folder)
from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from diagnosis_time import tall_recordings
from machine import described
from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from experiments.concealed.case import generate
from experiments.concealed.tables import case_name, combination_of

SEED, FIRST_EDITION = 2024, "eca9a7b"
ROUND = 41
"""Cases that hold every mechanism at every place of the rig once."""

KINDS: Mapping[str, tuple[str, ...]] = {
    "nothing concealed": ("",),
    "smooth laws": ("cubic_stiffness", "quadratic_drag"),
    "friction and slip": ("coulomb_friction", "hysteresis"),
    "ten storeys": ("tall",),
}
COMMAND = """
try:
    from twin.__main__ import main
except ImportError:  # the first edition's
    from twin.cli import main
main()
"""


def recordings_of(what: str, folder: Path) -> tuple[str, Path]:
    """Write the recordings of a case; return its model and the folder that they are in."""
    if what == "tall":
        return str(tall_recordings(folder)), folder
    if not what:
        generate(1, SEED, folder, folder / "sealed", "none")
        return "two_storey_lumped", folder / case_name(1, "none")
    number = next(n for n in range(1, ROUND + 1)
                  if [name for name, _ in combination_of("single", n, SEED)] == [what])  # fmt: skip
    generate(number, SEED, folder, folder / "sealed")
    return "two_storey_lumped", folder / case_name(number)


def answered(source: Path, model: str, folder: Path, out: Path) -> dict[str, Any]:
    """Diagnose with the package in a folder; return the seconds, and what was found."""
    command = [sys.executable, "-c", COMMAND, "diagnose", model, "--out", str(out)]
    for flag, pattern in (("--train", "train_*.csv"), ("--test", "test_*.csv")):
        for file in sorted(folder.glob(pattern)):
            command += [flag, str(file)]
    threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    begin = time.perf_counter()
    done = subprocess.run(command, env={**os.environ, **threads, "PYTHONPATH": str(source)},
                          cwd=out.parent, capture_output=True, text=True)  # fmt: skip
    seconds = time.perf_counter() - begin
    if done.returncode:
        last = (done.stderr.strip() or done.stdout.strip()).splitlines()
        return {"seconds": seconds, "found": last[-1] if last else "no answer"}
    found = json.loads((out / "diagnosis.json").read_text())
    names = [f"{f['mechanism']} {f['location']}" for f in found["findings"]]
    return {"seconds": seconds, "found": ", ".join(names) or found["verdict"]}


def compared(what: str, sources: Mapping[str, Path], turns: int) -> dict[str, Any]:
    """Diagnose a case with every commit in turns; return seconds and answers by commit."""
    with tempfile.TemporaryDirectory() as name:
        (folder := Path(name) / "case").mkdir()
        model, where = recordings_of(what, folder)
        row: dict[str, Any] = {"seconds": {s: [] for s in sources}, "found": {}}
        for _ in range(turns):
            for label, source in sources.items():
                answer = answered(source, model, where, Path(name) / label)
                row["seconds"][label].append(answer["seconds"])
                row["found"][label] = answer["found"]
    return row


def table_of(rows: Mapping[str, Mapping[str, Any]]) -> Table:
    """Return a table of medians and of their ratios."""
    table = Table("concealed", "before [s]", "now [s]", "ratio", "found before", "found now")
    for what, row in rows.items():
        before, now = (float(np.median(row["seconds"][label])) for label in ("before", "now"))
        table.add_row(what, f"{before:.1f}", f"{now:.1f}", f"{before / now:.2g}",
                      row["found"]["before"], row["found"]["now"])  # fmt: skip
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--commit", default=FIRST_EDITION, help="that is compared with")
    parser.add_argument("--kinds", nargs="*", default=list(KINDS), choices=KINDS)
    parser.add_argument("--turns", type=int, default=1)
    parser.add_argument("--json", type=Path, required=True)
    chosen = parser.parse_args()
    said = json.loads(chosen.json.read_text()) if chosen.json.exists() else {}
    if said.get("commit", chosen.commit) != chosen.commit:
        parser.error(f"{chosen.json} is about {said['commit']}: name another file")
    rows: dict[str, Any] = said.get("rows", {})
    console = Console()
    with tempfile.TemporaryDirectory() as name:
        before = Path(name) / "before"
        git = ["git", "-C", str(ROOT), "worktree"]
        subprocess.run([*git, "add", "--detach", str(before), chosen.commit], check=True,
                       capture_output=True)  # fmt: skip
        try:
            sources = {"before": before, "now": ROOT}
            compared("", sources, 1)  # compiles what is compiled
            for what in (w for kind in chosen.kinds for w in KINDS[kind]):
                label = what or "nothing"
                if label in rows:
                    continue
                rows[label] = compared(what, sources, chosen.turns)
                said = {"machine": described(), "commit": chosen.commit, "rows": rows}
                chosen.json.write_text(json.dumps(said, indent=1) + "\n")
                console.print(table_of({label: rows[label]}))
        finally:
            subprocess.run([*git, "remove", "--force", str(before)], check=True)
    console.print(table_of(rows))


if __name__ == "__main__":
    main()
