"""OKID and ERA against what a user would pick instead: time and peak memory, as ratios.

Every measurement has a process of its own and one BLAS thread; times are processor time. The
methods take turns (A B C, A B C, ..), so that a busy machine slows all of them alike, and a ratio
is the median of the ratios of each turn.

    python benchmarks/identification_speed.py --json benchmarks/results/identification_speed.json
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import peers
from machine import described
from rich.console import Console
from rich.progress import track
from rich.table import Table

WORKER = Path(__file__).with_name("speed_worker.py")
LIMIT_S = 60.0
LIMIT_GIB = 8.0
SLOW_S = 8.0
"""Beyond this a method is measured once only."""
REPEATS = 5

OBSERVER_LENGTH = 20
RECORDS = [(n, m) for m in (2, 16, 64) for n in (10_000, 100_000, 1_000_000)]
"""Samples and outputs, one input."""
FEW_RECORDS = [(10_000, 2), (100_000, 2), (10_000, 16), (10_000, 64)]
"""For SIPPY, which needs minutes beyond."""
MARKOV = [(400, 2, 3), (400, 16, 17), (1000, 16, 17), (2000, 64, 1), (2000, 64, 65)]
"""Markov parameters, outputs, columns (inputs, and outputs for the observer gain)."""

NEEDS = {
    "modred OKID": "modred",
    "python-control markov": "control",
    "SIPPY PARSIM-K": "sippy_unipi",
    "pymor randomised ERA": "pymor",
    "pymor ERA": "pymor",
    "python-control ERA": "control",
    "modred ERA": "modred",
}
GROUPS = {
    "OKID": ("twin OKID", ["modred OKID"]),
    "400 Markov parameters": ("twin OKID, 400 parameters", ["python-control markov"]),
    "OKID + ERA": ("twin OKID + ERA", ["SIPPY PARSIM-K"]),
    "ERA": ("twin ERA", ["pymor randomised ERA", "pymor ERA", "python-control ERA", "modred ERA"]),
}


def ask(seconds: float = LIMIT_S, **request: object) -> dict:
    """Run the worker; {"failed": why} where it exceeds a limit."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    command = [sys.executable, str(WORKER), json.dumps(request)]
    try:
        # The limit is one of processor time; the clock may show more on a busy machine.
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=2.5 * seconds
        )
    except subprocess.TimeoutExpired:
        return {"failed": f"over {LIMIT_S:g} s"}
    if done.returncode or (request["do"] == "measure" and not done.stdout.strip()):
        return {"failed": (done.stderr.strip().splitlines() or ["killed"])[-1][:80]}
    answer = json.loads(done.stdout) if done.stdout.strip() else {}
    if answer.get("failed") == "MemoryError":
        return {"failed": f"over {LIMIT_GIB:g} GiB"}
    if answer.get("seconds", 0) > LIMIT_S:
        return {"failed": f"over {LIMIT_S:g} s"}
    return answer


def compared(group: str, size: tuple[int, ...], small: Path, path: Path, turns: int, hopeless: set):
    """Measure every method of a group in turns; one row a method."""
    ours, others = GROUPS[group]
    methods = [ours, *(m for m in others if peers.installed(NEEDS[m]))]
    runs: dict[str, list[dict]] = {m: [] for m in methods}
    for turn in range(turns):
        for method in methods:
            known = runs[method]
            if (method, *size) in hopeless or (known and "failed" in known[0]):
                continue
            if turn and known[0]["seconds"] > SLOW_S:
                continue
            request = {"method": method, "small": str(small), "path": str(path)}
            found = ask(do="measure", repeats=REPEATS, limit_gib=LIMIT_GIB, **request)
            known.append(found)
    rows = []
    for method, found in runs.items():
        row: dict[str, object] = {"group": group, "size": list(size), "method": method}
        if not found or "failed" in found[0]:
            row["skipped"] = found[0]["failed"] if found else "a smaller one was too large"
            rows.append(row)
            continue
        mine = runs[ours]
        ratios = [
            theirs["seconds"] / own["seconds"] for theirs, own in zip(found, mine, strict=False)
        ]
        for key in ("seconds", "peak_mib", "deviation"):
            row[key] = float(np.median([f[key] for f in found]))
        row["time_ratio"] = float(np.median(ratios))
        own_peak = float(np.median([f["peak_mib"] for f in mine]))
        row["memory_ratio"] = row["peak_mib"] / max(own_peak, 0.1)  # type: ignore[operator]
        rows.append(row)
    return rows


def larger(size: tuple[int, ...], than: tuple[int, ...]) -> bool:
    return size != than and all(a >= b for a, b in zip(size, than, strict=True))


def tables(rows: list[dict]) -> list[Table]:
    made = []
    for group, (ours, _) in GROUPS.items():
        title = f"{group}; ratios against {ours}, above 1 is in our favour"
        table = Table(
            "size", "method", "time", "ratio", "peak memory", "ratio", "error", title=title
        )
        last = None
        for row in (r for r in rows if r["group"] == group):
            label = size_label(group, row["size"])
            if last not in (None, label):
                table.add_section()
            cells = [f"{row['method']}"]
            if "skipped" in row:
                cells += [f"skipped: {row['skipped']}", "", "", "", ""]
            else:
                seconds = row["seconds"]
                time = f"{1e3 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"
                cells += [time, f"{row['time_ratio']:.3g}", f"{row['peak_mib']:.4g} MiB"]
                cells += [f"{row['memory_ratio']:.3g}"]
                cells += ["" if np.isnan(row["deviation"]) else f"{row['deviation']:.2g}"]
            table.add_row("" if label == last else label, *cells)
            last = label
        made.append(table)
    return made


def size_label(group: str, size: list[int]) -> str:
    if group == "ERA":
        return f"{size[0]} parameters {size[1]} x {size[2]}"
    return f"{size[0]:.0e} samples, {size[1]} outputs".replace("e+0", "e")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--group", choices=list(GROUPS), action="append")
    parser.add_argument("--quick", action="store_true", help="the smallest size of each only")
    parser.add_argument("--json", type=Path, help="update this file with the groups measured")
    chosen = parser.parse_args()
    console = Console()
    for line in peers.missing_lines():
        console.print(line)
    groups = chosen.group or list(GROUPS)
    sizes = {"ERA": MARKOV, "OKID + ERA": FEW_RECORDS}
    jobs = [(g, s) for g in groups for s in sizes.get(g, RECORDS)]
    if chosen.quick:
        jobs = [(g, s) for g, s in jobs if s in (RECORDS[0], MARKOV[0])]
    rows: list[dict] = []
    with tempfile.TemporaryDirectory() as folder:
        small_record, small_markov = Path(folder, "record.npz"), Path(folder, "markov.npz")
        ask(do="record", path=str(small_record), size=[1000, 2, 5])
        ask(do="markov", path=str(small_markov), size=[60, 2, 2])
        for group, size in track(jobs, "sizes", console=console, transient=True):
            path = Path(folder, "task.npz")
            if group == "ERA":
                ask(do="markov", path=str(path), size=list(size))
            else:
                ask(do="record", path=str(path), size=[*size, OBSERVER_LENGTH])
            failed = [r for r in rows if "skipped" in r and r["group"] == group]
            hopeless = {(r["method"], *size) for r in failed if larger(size, tuple(r["size"]))}
            small = small_markov if group == "ERA" else small_record
            rows += compared(group, size, small, path, chosen.turns, hopeless)
    for table in tables(rows):
        if table.row_count:
            console.print(table)
    if chosen.json:
        kept = json.loads(chosen.json.read_text())["rows"] if chosen.json.exists() else []
        kept = [r for r in kept if r["group"] not in groups]
        result = {"machine": described(), "versions": peers.versions(), "rows": kept + rows}
        chosen.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
