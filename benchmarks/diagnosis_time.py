"""How long a diagnosis takes from files to answer, step by step; and that of a ten-storey frame.

The cases are those of ``experiments.concealed``: a two-storey rig in which one effect is hidden,
four recordings to explain and two unseen ones, 24 to 30 s at 256 Hz. The frame of ten storeys has
a cubic spring in its fourth and comes from the virtual laboratory.

    python benchmarks/diagnosis_time.py --json benchmarks/results/diagnosis_time.json
"""

# ruff: noqa: E402  (numpy reads the number of threads when it is imported)
from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

for threads in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

import numpy as np
from machine import described
from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(Path(__file__).parent.parent))

from experiments.concealed.case import case_name, generate
from twin.cli.diagnose import diagnose_files
from twin.formats import write_recording
from twin.frame.design import FrameDesign
from twin.instruments import Instrument
from twin.laboratory import Analyser, Experiment, Hammer, RandomShaking, run
from twin.laboratory.excitation import Excitation
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.model import Twin

SEED = 2024
GROUPS = (
    "reading",
    "calibrating",
    "locating and screening",
    "fitting",
    "further mechanism",
    "judging",
    "simulating",
    "drawing",
)
FIRST_WORDS = {
    "reading": "reading",
    "calibrating": "calibrating",
    "judging": "judging",
    "predicting": "simulating",
    "drawing": "drawing",
}

STOREYS, GUILTY = 10, "storey4"
CUBIC = 1e6
"""[N/m^3]: at the largest drift, 12 mm, a quarter of the storey's linear force."""
NOISE = 0.005
"""Share of every channel's RMS."""
TESTS: tuple[tuple[str, Excitation, str], ...] = (
    ("train_1", Hammer(peak_n=15.0), "floor10"),
    ("train_2", RandomShaking(rms_n=1.0, band_hz=(0.3, 12.0)), "floor4"),
    ("train_3", RandomShaking(rms_n=0.3, band_hz=(0.3, 12.0)), "floor8"),
    ("train_4", Hammer(peak_n=15.0), "floor3"),
    ("test_1", Hammer(peak_n=10.0), "floor6"),
    ("test_2", RandomShaking(rms_n=0.7, band_hz=(0.3, 12.0)), "floor2"),
)


def group_of(step: str) -> str:
    """Return the group of a step; what is fitted after the first mechanism is a further one."""
    first, *more = step.split()
    if first != "search":  # "search step 1: fitting ..."
        return FIRST_WORDS[first]
    number, what = more[1].rstrip(":"), more[2]
    if what == "screening":
        return "locating and screening"
    return "fitting" if number == "1" else "further mechanism"


def grouped(steps: Mapping[str, float]) -> dict[str, float]:
    """Add the steps up."""
    out = dict.fromkeys(GROUPS, 0.0)
    for name, seconds in steps.items():
        out[group_of(name)] += seconds
    return out


def diagnosed(model: str, folder: Path) -> dict[str, Any]:
    """Diagnose the recordings of a folder; times, and what was found."""
    train, test = sorted(folder.glob("train_*.csv")), sorted(folder.glob("test_*.csv"))
    begin, processor = time.perf_counter(), time.process_time()
    found = diagnose_files(model, train, test, None)
    return {
        "seconds": time.perf_counter() - begin,
        "processor_seconds": time.process_time() - processor,
        "steps": grouped(found["steps"]),
        "verdict": found["verdict"],
        "found": [
            {
                "name": f"{f['mechanism']} {f['location']}",
                "values": {k: p["value"] for k, p in f["parameters"].items()},
                "probability": f["probability"],
            }
            for f in found["findings"]
        ],
        "fit": found["fit"]["test"],
    }


def concealed(number: int, folder: Path) -> dict[str, Any]:
    """Diagnose one concealed case, and open its seal only then."""
    generate(number, SEED, folder / "recordings", folder / "sealed")
    name = case_name(number, "single")
    row = diagnosed("two_storey_lumped", folder / "recordings" / name)
    truth = json.loads((folder / "sealed" / f"{name}.json").read_text())
    return {"truth": f"{truth['mechanism']} {truth['location']}", **row}


def tall_recordings(folder: Path) -> Path:
    """Write the recordings of ten storeys; return their model, without its cubic spring."""
    model = Twin.of(FrameDesign.tall(STOREYS, kind="lumped"))
    rig = model.including(CubicStiffness(GUILTY, CUBIC))
    analyser = Analyser(sampling_hz=256.0, duration_s=24.0)
    noisy = {kind: Instrument(noise_fraction=NOISE) for kind in ("acc", "force")}
    for i, (name, excitation, place) in enumerate(TESTS):
        test = Experiment(excitation, place, analyser, instruments=noisy)
        write_recording(run(test, rig, SEED + i), folder / f"{name}.csv")
    return model.export(folder / "tall.xml")


def tall(folder: Path) -> dict[str, Any]:
    """Diagnose the frame of ten storeys."""
    path = tall_recordings(folder)
    return {"truth": f"cubic_stiffness {GUILTY}", "true_value": CUBIC} | diagnosed(
        str(path), folder
    )


def spread(values: list[float]) -> dict[str, float]:
    low, middle, high = np.percentile(values, [0, 50, 100])
    return {"median": middle, "least": low, "most": high}


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Medians over the cases; those of the steps need not add up to that of the whole."""
    return {
        "seconds": spread([r["seconds"] for r in rows]),
        "processor_seconds": spread([r["processor_seconds"] for r in rows]),
        "steps": {g: spread([r["steps"][g] for r in rows]) for g in GROUPS},
    }


def table_of(found: dict[str, Any]) -> Table:
    table = Table("step", "median [s]", "least to most [s]", "ten storeys [s]")
    whole, ten = found["summary"], found.get("tall")
    for group in GROUPS:
        s = whole["steps"][group]
        last = f"{ten['steps'][group]:.2f}" if ten else ""
        table.add_row(group, f"{s['median']:.2f}", f"{s['least']:.2f} to {s['most']:.2f}", last)
    table.add_section()
    for name in ("seconds", "processor_seconds"):
        s, last = whole[name], f"{ten[name]:.1f}" if ten else ""
        row = (f"{s['median']:.1f}", f"{s['least']:.1f} to {s['most']:.1f}", last)
        table.add_row("all" if name == "seconds" else "all, processor time", *row)
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=6)
    parser.add_argument("--no-tall", action="store_true", help="leave the ten storeys out")
    parser.add_argument("--json", type=Path)
    chosen = parser.parse_args()
    console = Console()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        first = concealed(1, folder)  # compiles what is compiled, and imports
        rows = []
        for number in range(1, chosen.cases + 1):
            rows.append(concealed(number, folder))
            row = rows[-1]
            names = ", ".join(f["name"] for f in row["found"]) or row["verdict"]
            console.print(f"{row['truth']}: {names}; {row['seconds']:.1f} s")
        found: dict[str, Any] = {
            "machine": described(),
            "first_seconds": first["seconds"],
            "summary": summary(rows),
            "cases": rows,
        }
        if not chosen.no_tall:
            (folder / "tall").mkdir()
            found["tall"] = tall(folder / "tall")
            names = ", ".join(f["name"] for f in found["tall"]["found"])
            console.print(f"ten storeys, {found['tall']['truth']}: {names}")
    console.print(table_of(found))
    if chosen.json:
        chosen.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
