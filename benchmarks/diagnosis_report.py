"""Writes the tables of the diagnosis into README.md from the files in results/.

python benchmarks/diagnosis_report.py
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from calibration_sysid import ERRORS, OURS, STARTS, THEIRS
from diagnosis_time import GROUPS
from report import fill, run_line, table

FOLDER = Path(__file__).parent


def typical(rows: list[dict[str, Any]], method: str, key: str) -> float:
    """Root mean square over the rigs; of times the median."""
    values = np.array([row[method][key] for row in rows])
    return float(np.median(values) if key == "seconds" else np.sqrt(np.mean(values**2)))


def calibration(found: dict[str, Any]) -> str:
    """One table a start: errors over all rigs, and theirs over ours."""
    blocks = [run_line(found)]
    for start in STARTS:
        rows = [row for row in found["rows"] if row["start"] == start]
        if not rows:
            continue
        lines = []
        for method in ("true rig", "model", OURS, THEIRS):
            timed = "seconds" in rows[0][method]
            cells = [f"{100 * typical(rows, method, e):.3g}" for e in ERRORS]
            if method == "true rig":
                cells[:3] = ["0"] * 3
            time = f"{typical(rows, method, 'seconds'):.2f} s" if timed else ""
            lines.append([method, time, *cells])
        ratios = [
            f"{np.median([row[THEIRS][k] / row[OURS][k] for row in rows]):.3g}"
            for k in ("seconds", *ERRORS)
        ]
        lines.append([f"{THEIRS} / {OURS}, median", *ratios])
        header = ["", "processor time", *(f"{e} [%]" for e in ERRORS)]
        blocks += [f"### {start} start ({len(rows)} rigs)", table(header, lines)]
    return "\n\n".join(blocks)


def times(found: dict[str, Any]) -> str:
    whole, ten = found["summary"], found["tall"]
    lines = []
    for group in GROUPS:
        s = whole["steps"][group]
        middle, reach = f"{s['median']:.2f}", f"{s['least']:.2f} to {s['most']:.2f}"
        lines.append([group, middle, reach, f"{ten['steps'][group]:.2f}"])
    for key, name in (("seconds", "all"), ("processor_seconds", "all, processor time")):
        s = whole[key]
        reach = f"{s['least']:.1f} to {s['most']:.1f}"
        lines.append([f"**{name}**", f"{s['median']:.1f}", reach, f"{ten[key]:.1f}"])
    header = ["step", "median [s]", "least to most [s]", "ten storeys [s]"]
    cases = [
        [
            row["truth"],
            ", ".join(f["name"] for f in row["found"]) or row["verdict"],
            f"{row['seconds']:.1f}",
            f"{100 * row['fit']['explained']:.3g} ({100 * row['fit']['noise_floor']:.3g})",
        ]
        for row in [*found["cases"], ten]
    ]
    named = ["hidden", "found", "time [s]", "NRMSE of the unseen (noise floor) [%]"]
    parts = (found["machine"] + ".", table(header, lines), table(named, cases))
    return "\n\n".join(parts)


def main() -> None:
    read = {
        name: json.loads((FOLDER / "results" / f"{name}.json").read_text())
        for name in ("calibration_sysid", "diagnosis_time")
    }
    blocks = {
        "calibration": calibration(read["calibration_sysid"]),
        "diagnosis time": times(read["diagnosis_time"]),
    }
    fill(blocks)


if __name__ == "__main__":
    main()
