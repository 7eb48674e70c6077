"""Many modes: ours beside what a user would pick instead, on the same records, in one run.

    pip install sdypy-EMA pyOMA-2 control sippy-unipi pymor
    python benchmarks/modal_peers.py [--only plate|frame] [--json FILE]

The plate of ``experiments/modal_test_size.py`` and the two-storey frame on a random shaker, from
its accelerations alone. sdypy-EMA and pyOMA2 get, as a person would pick in their diagrams, the
frequencies near which poles are to be chosen: their modes are asked for, none can be spurious.
python-control, pymor and SIPPY get the true order. Ours gets the records and no hint. Every method
has a process of its own and ``--limit`` seconds; memory is the peak of that process, the imports
included. A peer that is not installed is skipped. Hits of a real part: ``hammer_peers.py``.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from frame_bound import frame_bound
from machine import described
from modal_methods import METHODS, OUTPUT_ONLY, alone
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(Path(__file__).parents[1] / "experiments"))

from modal_test_size import BAND, NOISE, Plate, bound, drawn

from twin import shaker_test
from twin.model import Twin
from twin.recording import Recording

Array = NDArray[np.float64]

FRAME_BAND = (0.5, 12.5)
"""[Hz]"""


def plate(console: Console, limit: float) -> list[dict[str, Any]]:
    """Find the plate's modes with every method."""
    made = Plate.of()
    true = made.omega / (2 * np.pi)
    recording, _ = drawn(made, 0, NOISE)
    limits = bound(made, 0)
    table = Table("plate, 40 modes", "found", "spurious", "frequency", "damping", "s", "GB")
    rows = []
    for name in METHODS:
        found = alone(name, [recording], BAND, true, limit)
        row: dict[str, Any] = {"method": name}
        if "error" in found:
            row["error"] = found["error"]
            table.add_row(name, row["error"])
            rows.append(row)
            continue
        f, zeta = np.array(found["frequency"]), np.array(found["damping"])
        pairs = matched(true, made.zeta * true, f)
        off = [
            [abs(values[j] - t[i]) / b[i] for i, j in pairs.items()]
            for values, t, b in zip((f, zeta), (true, made.zeta), limits, strict=True)
        ]
        row |= {
            "found": len(pairs), "spurious": None if found["hinted"] else len(f) - len(pairs),
            "over_bound": [float(np.median(x)) if x else None for x in off],
            "seconds": found["seconds"], "memory_gb": found["memory_gb"],
        }  # fmt: skip
        rows.append(row)
        spurious = "told where" if row["spurious"] is None else str(row["spurious"])
        errors = ["" if x is None else f"{x:.2f}" for x in row["over_bound"]]
        table.add_row(name, str(len(pairs)), spurious, *errors, f"{found['seconds']:.1f}",
                      f"{found['memory_gb']:.2f}")  # fmt: skip
    console.print(table, "frequency and damping: median error of what is found, over the bound")
    return rows


def matched(true: Array, width: Array, found: Array) -> dict[int, int]:
    """Return true mode -> found mode nearest to it, within a width and each once."""
    pairs: dict[int, int] = {}
    for i, f in enumerate(true):
        j = int(np.argmin(np.abs(found - f))) if len(found) else -1
        if j >= 0 and abs(found[j] - f) < width[i] and j not in pairs.values():
            pairs[i] = j
    return pairs


def frame(console: Console, draws: int) -> list[dict[str, Any]]:
    """Find the frame's modes from its accelerations alone, on a random shaker."""
    modes = Twin.load("two_storey_lumped").modes()
    true = np.array([modes.natural_freq, modes.damping_ratio])
    rows: list[dict[str, Any]] = []
    for name, method in OUTPUT_ONLY.items():
        errors, inside, stated = [], [], []
        row: dict[str, Any] = {"method": name, "draws": draws, "missed": 0, "spurious": 0}
        for seed in range(draws):
            try:
                found = np.array(method([_shaken(seed)], FRAME_BAND, true[0]))
            except ImportError as error:
                row["error"] = f"skipped: {error.name} is not installed"
                break
            pairs = matched(true[0], 3 * true[1] * true[0], found[0])
            row["spurious"] += len(found[0]) - len(pairs)
            if len(pairs) < len(true[0]):
                row["missed"] += 1
                continue
            at = [pairs[i] for i in range(len(true[0]))]
            off = found[:2, at] - true
            errors.append(off / true)
            stated.append(found[2:, at] / true)
            inside.append(np.abs(off) <= 1.96 * found[2:, at])
        if errors:
            row["rms_error"] = np.sqrt(np.mean(np.square(errors), axis=0)).tolist()
            row["stated"] = np.mean(stated, axis=0).tolist()
            row["covered"] = np.mean(inside, axis=0).tolist()
        rows.append(row)
    limits = frame_bound(_shaken(0), FRAME_BAND, NOISE)
    rows.append({"method": "Cramér-Rao bound", "bound": limits.tolist()})
    table = Table("frame, outputs alone", "f1 [%]", "f2 [%]", "damping 1 [%]", "damping 2 [%]",
                  "95 % intervals hold", "missed", "spurious", "stated for damping")  # fmt: skip
    for row in rows:
        if "bound" in row:
            table.add_row(row["method"], *(f"{100 * x:.3g}" for x in np.ravel(row["bound"])))
            continue
        if "rms_error" not in row:
            table.add_row(row["method"], row.get("error", ""))
            continue
        table.add_row(
            row["method"],
            *(f"{100 * x:.3g}" for x in np.ravel(row["rms_error"])),
            ", ".join(f"{x:.0%}" for x in np.ravel(row["covered"])),
            str(row["missed"]),
            str(row["spurious"]),
            ", ".join(f"{100 * x:.3g}" for x in row["stated"][1]),
        )
    console.print(table, f"root mean square of relative errors, {draws} draws")
    return rows


def _shaken(seed: int) -> Recording:
    """Return the accelerations of the frame; the force is white up to the analyser's filter."""
    recording = shaker_test(
        "two_storey_lumped", "force_floor1", band_hz=(0.2, 16.0), duration_s=256.0, noise=NOISE,
        seed=seed,
    )  # fmt: skip
    outputs = {
        f"{c.name} [{c.unit}]": recording.column(c.name)
        for c in recording.channels
        if c.name.startswith("acc_floor")
    }
    return Recording.build(recording.sampling_hz, outputs, source="shaken frame")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=("plate", "frame"), help="this part alone")
    parser.add_argument("--draws", type=int, default=20, help="of the shaken frame")
    parser.add_argument("--limit", type=float, default=300.0, help="seconds a method may take")
    parser.add_argument("--json", type=Path, help="file for the results")
    options = parser.parse_args()
    console = Console()
    kept = options.json is not None and options.json.exists()
    found: dict[str, Any] = json.loads(options.json.read_text(encoding="utf-8")) if kept else {}
    found["machine"] = described()
    parts = {"plate": lambda: plate(console, options.limit),
             "frame": lambda: frame(console, options.draws)}  # fmt: skip
    for name, part in parts.items():
        if options.only not in (None, name):
            continue
        found[name] = part()
        if options.json:
            options.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
