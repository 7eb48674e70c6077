"""A full-scale building on rubber isolators, diagnosed from its shake-table recordings.

The twin is written from round numbers: six lumped floors of 100 t, an isolation layer that gives
0.4 Hz, storeys that give the building on it 1.5 Hz. None of them is known; each recording is held
out in turn and predicted from the others.

    python -m experiments.bncs FOLDER [--held LAC100] [--tolerance 0.5]

FOLDER holds recordings with ``acc_ground`` and ``acc_floor1`` to ``acc_floor6`` as CSV. Source of
three of them: the base-isolated phase of the BNCS project (Orozco, Hernandez and Astroza).
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.pipeline import diagnose
from twin.diagnosis.predict import placed
from twin.diagnosis.prepare import UNKNOWN, prepare
from twin.diagnosis.simulation import OutputError, independent_share
from twin.formats import read_recording
from twin.frame import FrameDesign, Ground, Storey
from twin.model import Twin
from twin.recording import Recording

FLOOR_KG = 1e5
ISOLATION, STOREY = 4e6, 1e8
"""Stiffness of the isolators together, and of each storey above them [N/m]."""
DAMPING = (0.10, 0.03)
HEIGHT_M, MODULUS = 3.0, 2e11


def round_twin() -> Twin:
    """Return the six-storey lumped twin from round numbers."""
    stiffnesses = (ISOLATION, *[STOREY] * 5)
    storeys = tuple(
        Storey(FLOOR_KG, HEIGHT_M, MODULUS, second_moment=k * HEIGHT_M**3 / (24 * MODULUS))
        for k in stiffnesses
    )
    ground = Ground(mass=FLOOR_KG)
    return Twin.of(FrameDesign(storeys, kind="lumped", ground=ground, damping_ratio=DAMPING))


def equivalent_linear(train: Sequence[Recording], held: Recording) -> float:
    """Return the error of the best equivalent-linear twin: refitted to the held-out motion itself.

    Stiffness and damping of the isolation are those that suit that motion best, which no one knows
    beforehand; all else stays as the training recordings have it.
    """
    ready = prepare(round_twin(), train, [held], UNKNOWN, UNKNOWN)
    first = Hypothesis(ready.train)
    z = np.zeros(len(first.unknowns))
    own, there = placed(first, OutputError(first).fitted(z).z, ready.test)
    model = OutputError(own)
    tau = independent_share(model.residuals(there))
    names = [u.name for u in own.unknowns]
    moving = np.isin(names, ["stiffness storey1", "damping of mode 1"])
    suited = replace(model, tau=tau).fitted(there, moving).z
    measured = ready.test.recordings[0].y
    left = np.linalg.norm(np.vstack(model.residuals(suited)))
    return float(left / np.sqrt(np.nansum(measured**2)))


def predicted(
    recordings: dict[str, Recording], held: str, tolerance: float | None
) -> dict[str, Any]:
    """Diagnose all recordings but one and return what was found and how that one is predicted."""
    train = [r for name, r in recordings.items() if name != held]
    begin = time.perf_counter()
    found = diagnose(
        round_twin(), train, [recordings[held]], unknown=tolerance is None,
        tolerance=tolerance, damping_tolerance=tolerance,
    )  # fmt: skip
    seconds = time.perf_counter() - begin
    test = found.fit.test
    return {
        "verdict": found.verdict,
        "found": [f"{f.mechanism.name} {f.location}" for f in found.findings],
        "calibrated linear twin": test.calibrated,
        "best equivalent-linear twin": equivalent_linear(train, recordings[held]),
        "explained twin": test.explained,
        "stated beforehand": test.stated,
        "seconds": seconds,
        "notes": list(found.notes),
    }


def main(arguments: Sequence[str] | None = None) -> dict[str, Any]:
    """Run the rotations that are wanted and print one table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--held", nargs="+", help="recordings that are held out; each in turn")
    parser.add_argument("--tolerance", type=float, help="share instead of unknown numbers")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args(arguments)
    files = sorted(given.folder.glob("*.csv"))
    recordings = {path.stem: read_recording(path) for path in files}
    kept = {}
    columns = ("calibrated linear twin", "best equivalent-linear twin", "explained twin",
               "stated beforehand")  # fmt: skip
    table = Table("held out", "found", *columns, "seconds")
    for held in given.held or recordings:
        kept[held] = row = predicted(recordings, held, given.tolerance)
        cells = ["-" if row[c] is None else f"{row[c]:.3f}" for c in columns]
        cells = [held, ", ".join(row["found"]), *cells, f"{row['seconds']:.0f}"]
        table.add_row(*cells)
        print("; ".join(cells), flush=True)
    Console(width=160).print(table)
    for note in dict.fromkeys(note for row in kept.values() for note in row["notes"]):
        print(f"note: {note}")
    if given.json:
        given.json.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    return kept


if __name__ == "__main__":
    main()
