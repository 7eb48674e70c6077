"""What holds on any structure, as a section of the proof: engine, identification, closure.

    python -m experiments.structures_identified --out identified
    python -m experiments.closure --out closure
    python -m experiments.any_structure --identified identified --closure closure --to FILE

Compares the engine with MuJoCo (half a minute) and reads what ``structures_identified`` and
``closure`` left in their folders.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from experiments import closure, structures_identified
from experiments.engine_against_mujoco import GENTLE, STRONG, line, models, with_corners
from twin.files import write_whole

Table = dict[str, Any]
TEXT = (
    "The engine on a chain and on structures that are none. First its free run beside MuJoCo's "
    "own, as a share of the response's RMS; then natural frequencies and dampings that "
    "`twin.identify` finds in shaker tests with 1 % noise on every channel, counted where they lie "
    "within three of their stated standard deviations of the model's; then the closure: a twin "
    "that has a mechanism is diagnosed with virtual recordings of itself (own), the twin that "
    "lacks it gets it named, and the twin so explained is diagnosed again. What a structure's rows "
    "lack was not run to its end; the chain's row of dry friction was wrong on 9ad5bfa and is that "
    "of c1b6077."
)
COMMANDS = (
    "python -m experiments.structures_identified --out identified",
    "python -m experiments.closure --out closure",
    "python -m experiments.any_structure --identified identified --closure closure "
    "--to experiments/results/structures.json",
)


def rows_of(folder: Path, name: str) -> dict[str, Any]:
    """Return what a campaign left in its folder, by name."""
    lines = (json.loads(text) for text in (folder / name).read_text().splitlines())
    return {row["name"]: row["result"] for row in lines if "name" in row}


def engine() -> list[Table]:
    """Return the engine beside MuJoCo, linear models and laws with corners."""
    rows = []
    for name, (twin, shaken) in models().items():
        first, strong = (line(name, twin, shaken, reach) for reach in (GENTLE, STRONG))
        every = (first, strong, line(name, twin, shaken, STRONG, large=True))
        rows.append([name, first.freedoms, *(f"{100 * x.worst:.2g} %" for x in every)])
    corners = [[name, law, f"{100 * share:.2g} %"] for name, law, share in with_corners()]
    return [
        {
            "title": "Linear models: largest difference of any channel",
            "columns": [
                "Model",
                "Degrees of freedom",
                "At 0.1 mm or mrad",
                "At 10 mm or mrad",
                "The same, with large motion's pseudo-forces",
            ],
            "rows": rows,
        },
        {
            "title": "With a law that has corners: difference of all channels together",
            "columns": ["Model", "Law", "Difference"],
            "rows": corners,
        },
    ]


def identified(results: dict[str, Any]) -> Table:
    """Return of every mode in how many draws it was found, and within three deviations."""
    rows = []
    for model in structures_identified.PLANS:
        draws = [r for name, r in results.items() if name.startswith(f"{model} ")]
        if not draws:
            continue
        spurious = sum(r.get("spurious", 0) for r in draws)
        for i, f in enumerate(structures_identified.true_modes(model)[0]):
            cells = []
            for key in ("frequency", "damping"):
                values = (r[key][i] for r in draws if key in r)
                errors = np.array([value for value in values if value is not None])
                within = int(np.sum(np.abs(errors) < structures_identified.DEVIATIONS))
                spread = f"{np.mean(errors):+.1f} +- {np.std(errors):.1f}"
                cells.append(f"{within} of {len(draws)} ({spread})")
            rows.append([model, f"{f:.3f}", *cells, spurious if not i else ""])
    return {
        "title": "Modes within three standard deviations (and the error in them)",
        "columns": ["Structure", "Mode [Hz]", "Frequency", "Damping", "Spurious modes"],
        "rows": rows,
    }


def closed(results: dict[str, Any], commits: str = "") -> Table:
    """Return the closure's table; its title says on which commits it was diagnosed."""
    rows = [
        [*name.split(" ", 1), row["place"], *(row[step] for step in closure.STEPS)]
        for name, row in results.items()
    ]
    totals = []
    for structure in dict.fromkeys(row[0] for row in rows):
        shares = []
        for step in range(3, 6):
            asked = [row[step] for row in rows if row[0] == structure and row[step] != "-"]
            shares.append(f"{sum(cell == 'right' for cell in asked)} of {len(asked)}")
        totals.append([structure, "all", "", *shares])
    return {
        "title": f"Closure ({commits})" if commits else "Closure",
        "columns": ["Structure", "Mechanism", "Place", "Own", "Named", "Again"],
        "rows": [*rows, *totals],
    }


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--identified", type=Path, required=True)
    parser.add_argument("--closure", type=Path, required=True)
    parser.add_argument("--commits", default="", help="on which the closure was diagnosed")
    parser.add_argument("--to", type=Path, required=True)
    given = parser.parse_args()
    section = {
        "text": TEXT,
        "command": "\n".join(COMMANDS),
        "tables": [
            *engine(),
            identified(rows_of(given.identified, "draws.jsonl")),
            closed(rows_of(given.closure, "closure.jsonl"), given.commits),
        ],
    }
    text = json.dumps(section, indent=1) + "\n"
    print(write_whole(given.to, lambda part: part.write_text(text, encoding="utf-8")))


if __name__ == "__main__":
    main()
