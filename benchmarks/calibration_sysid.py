"""Calibrating the two-storey frame: the innovations' likelihood against ``mujoco.sysid``.

Both start from the same model with the same unknowns (floor masses, storey stiffnesses, dampings:
ours of the modes, its dashpots in the storeys and at a floor) and the same recordings. The rigs are
those of ``experiments.concealed`` with nothing hidden: 0.3 % off the model, made by another
integrator. ``close`` starts at the shipped model, ``hard`` at one whose storeys are 15 % too stiff.
Our tolerance is the standard deviation of a normal prior; ``mujoco.sysid`` knows boxes only, and
gets three of it to either side.

``sysid_peer.py`` says what a careful user of it has to do, and does it.

    python benchmarks/calibration_sysid.py --json benchmarks/results/calibration_sysid.json
"""

# ruff: noqa: E402  (numpy reads the number of threads when it is imported)
from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

for threads in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

import mujoco
import numpy as np
import sysid_peer
from machine import described
from rich.console import Console
from rich.table import Table
from scipy.linalg import eigh

sys.path.insert(0, str(Path(__file__).parent.parent))

from experiments.concealed.case import generate
from experiments.concealed.rig import Rig
from twin.diagnosis.beginning import start_of
from twin.diagnosis.exported import base_mechanisms, in_mujoco, including
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.predict import nrmse
from twin.diagnosis.prepare import prepare
from twin.diagnosis.problem import Problem
from twin.estimation.fit import fit
from twin.formats import read_recording
from twin.mechanisms.damping import Damping
from twin.mechanisms.mass import Mass
from twin.mechanisms.mechanism import Mechanism, StructuralChange
from twin.mechanisms.stiffness import Stiffness
from twin.model import Twin
from twin.recording import Recording
from twin.second_order import SecondOrderModel

Array = np.ndarray
SEED = 2024
DAMPING_TOLERANCE = 0.1
STARTS = {"close": (1.0, 0.004), "hard": (1.15, 0.15)}
"""Stiffness of the model over the shipped one's, tolerance of masses and stiffnesses."""
OURS, THEIRS = "twin", "mujoco.sysid"
ERRORS = ("masses", "stiffnesses", "damping ratios", "test NRMSE")


def model_of(factor: float) -> Twin:
    """Return the shipped model with storeys stiffer by a factor."""
    twin = Twin.load("two_storey_lumped")
    spec = mujoco.MjSpec.from_string(twin.mjcf)
    for storey in ("storey1", "storey2"):
        spec.joint(storey).stiffness = factor * np.asarray(spec.joint(storey).stiffness)
    spec.compiler.savecompiled = False
    return Twin(spec.to_xml(), twin.source) if factor != 1 else twin


def ours(problem: Problem) -> tuple[Mechanism, ...]:
    hypothesis = Hypothesis(replace(problem))  # keeps nothing of a run before
    found = fit(hypothesis, start_of(hypothesis))
    return base_mechanisms(problem, found.z)


def edited(model: SecondOrderModel, changes: Sequence[Mechanism]) -> SecondOrderModel:
    for change in changes:
        assert isinstance(change, StructuralChange)
        model = change.edit(model)
    return model


def storey_stiffnesses(model: SecondOrderModel) -> Array:
    """Return the springs of a chain, from the bottom up [N/m]: what is seen at each drift."""
    rows = [model.port(name) for name in model.ports if name.startswith("storey")]
    compliance = np.linalg.inv(model.K)
    return np.array([1 / (row @ compliance @ row) for row in rows])


def damping_ratios(model: SecondOrderModel) -> Array:
    squares, shapes = eigh(model.K, model.M)
    return np.diag(shapes.T @ model.R @ shapes) / (2 * np.sqrt(squares))


def true_changes(model: SecondOrderModel, rig: Rig) -> list[Mechanism]:
    """Return what makes the rig of the model, exactly: three dashpots hold any damping matrix."""
    k = rig.stiffnesses - storey_stiffnesses(model)
    places = ("storey1", "storey2", "floor2")
    shapes = [Damping(p, 1.0).edit(model).R - model.R for p in places]
    c = np.linalg.lstsq(
        np.column_stack([s.ravel() for s in shapes]), (rig.damping - model.R).ravel(), rcond=None
    )[0]
    m = rig.masses - np.diag(model.M)
    return [
        *(Stiffness(f"storey{i + 1}", float(v)) for i, v in enumerate(k)),
        *(Damping(p, float(v)) for p, v in zip(places, c, strict=True)),
        *(Mass(f"floor{i + 1}", float(v)) for i, v in enumerate(m)),
    ]


def errors(twin: Twin, test: Problem, changes: Sequence[Mechanism], rig: Rig) -> dict[str, float]:
    """RMS relative errors, and NRMSE of the free run on the unseen recordings."""
    found = edited(twin.second_order(), changes)

    def off(values: Array, true: Sequence[float]) -> float:
        return float(np.sqrt(np.mean((values / np.array(true) - 1) ** 2)))

    changed = including(twin, changes)
    runs = [in_mujoco(changed, test, recording) for recording in test.recordings]
    return dict(
        zip(
            ERRORS,
            (
                off(np.diag(found.M), rig.masses),
                off(storey_stiffnesses(found), rig.stiffnesses),
                off(damping_ratios(found), rig.damping_ratios),
                nrmse([recording.y for recording in test.recordings], runs),
            ),
            strict=True,
        )
    )


def shortened(recording: Recording, seconds: float) -> Recording:
    count = min(len(recording.data), round(seconds * recording.sampling_hz))
    r = recording
    return Recording(r.sampling_hz, r.channels, r.data[:count], r.source, r.start_s, r.notes)


def one(number: int, start: str, folder: Path, seconds: float, most: int) -> dict[str, Any]:
    """Calibrate one rig both ways, ours before and after theirs; times are the processor's."""
    generate(number, SEED, folder, folder / "sealed", table="none")
    truth = json.loads((folder / "sealed" / f"none_{number:04d}.json").read_text())
    rig = Rig.from_json(truth["rig"])
    files = sorted((folder / f"none_{number:04d}").glob("*.csv"))
    recordings = {p.stem: read_recording(p) for p in files}
    train = [shortened(r, seconds) for n, r in recordings.items() if n.startswith("train")]
    factor, tolerance = STARTS[start]
    twin = model_of(factor)
    test = [r for n, r in recordings.items() if n.startswith("test")]
    ready = prepare(twin, train, test, tolerance, DAMPING_TOLERANCE)
    times, notes = [], dict[str, Any]()
    for _ in range(2):
        begin = time.process_time()
        mine = ours(ready.train)
        times.append(time.process_time() - begin)
        if len(times) == 1:
            begin = time.process_time()
            other, notes = sysid_peer.calibrated(twin, ready.train, ready.train.recordings, most)
            spent = time.process_time() - begin
    exact = true_changes(twin.second_order(), rig)
    return {
        "rig": number,
        "start": start,
        "noise": truth["noise"],
        "chain": truth["style"],
        OURS: {"seconds": min(times), **errors(twin, ready.test, mine, rig)},
        THEIRS: {"seconds": spent, **notes, **errors(twin, ready.test, other, rig)},
        "model": errors(twin, ready.test, [], rig),
        "true rig": errors(twin, ready.test, exact, rig),
    }


def table_of(rows: list[dict[str, Any]]) -> Table:
    table = Table("start, rig", "method", "time [s]", *(f"{e} [%]" for e in ERRORS))
    for row in rows:
        label = f"{row['start']}, rig {row['rig']}"
        for method in ("true rig", "model", OURS, THEIRS):
            cells = [f"{100 * row[method][e]:.3g}" for e in ERRORS]
            seconds = row[method].get("seconds")
            table.add_row(label, method, f"{seconds:.2f}" if seconds else "", *cells)
            label = ""
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rigs", type=int, default=3)
    parser.add_argument("--starts", nargs="+", choices=tuple(STARTS), default=tuple(STARTS))
    parser.add_argument("--seconds", type=float, default=30.0, help="of each training recording")
    parser.add_argument("--most", type=int, default=100, help="iterations of mujoco.sysid")
    parser.add_argument("--json", type=Path)
    chosen = parser.parse_args()
    if not hasattr(sysid_peer.sysid, "optimize"):
        raise SystemExit("mujoco.sysid is not complete: pip install 'mujoco[sysid]'")
    with tempfile.TemporaryDirectory() as name:
        rows = []
        for start in chosen.starts:
            for number in range(1, chosen.rigs + 1):
                rows.append(one(number, start, Path(name), chosen.seconds, chosen.most))
                print(json.dumps(rows[-1]), flush=True)
    Console().print(table_of(rows))
    if chosen.json:
        versions = {"mujoco": mujoco.__version__, "numpy": np.__version__}
        found = {"machine": described(), "versions": versions, "seconds": chosen.seconds}
        found |= {"most": chosen.most, "rows": rows}
        chosen.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
