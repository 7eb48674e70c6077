"""What others say and reach on concealed cases: ``mujoco.sysid``, ``pysindy``, ``sysidentpy``.

    python benchmarks/diagnosis_peers.py CAMPAIGN --cases 20 --python /path/to/peers/bin/python

CAMPAIGN is a folder that ``twin concealed --out`` wrote. ``pysindy`` and ``sysidentpy`` want an
older NumPy than this package: --python is that of an environment of their own (``pip install
pysindy sysidentpy``). Every peer gets the training recordings and is judged on the same test
recordings as we are; results are kept case by case and a run goes on where the last one stopped.

"says" is what a peer names, mechanism and place: ``mujoco.sysid`` gets credit for a parameter of
the model that left its tolerance, ``pysindy`` for a term of its library that is the mechanism's
law; ``sysidentpy`` has no such feature.
"""

# ruff: noqa: E402  (numpy reads the number of threads when it is imported)
from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

for threads in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

import numpy as np
from diagnosis_peers_data import Case, save
from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(Path(__file__).parent.parent))

from twin.arrays import filled
from twin.diagnosis.prepare import Prepared, prepare
from twin.errors import TwinError
from twin.files import write_whole
from twin.formats import read_recording
from twin.model import Twin

HERE = Path(__file__).parent
RESULTS = HERE.parent / "experiments" / "results" / "peers.json"
MODEL = "two_storey_lumped"
OURS = "twin"
PEERS = ("mujoco.sysid", "pysindy", "sysidentpy")
FEATURE = {
    "mujoco.sysid": "none for what the model lacks; parameters it has, that left their tolerance",
    "pysindy": "terms of a library that the user writes, at the states that it is given",
    "sysidentpy": "none: regressors on lagged signals, no places",
}
LIMIT_S = 900


def ready_of(folder: Path) -> Prepared:
    """Read a case's recordings.

    Raises:
        TwinError: they are not of forces on the two floors of the model.
    """
    read = {path.stem: read_recording(path) for path in sorted(folder.glob("*.csv"))}
    roles = ("train", "test")
    train, test = ([r for n, r in read.items() if n.startswith(role)] for role in roles)
    ready = prepare(Twin.load(MODEL), train, test)
    model = ready.train.model
    allowed = {"force_floor1", "force_floor2", "acc_floor1", "acc_floor2"}
    if set(model.inputs + model.outputs) - allowed or len(model.outputs) < 2:
        raise TwinError(f"{folder.name}: not forces on and accelerations of two floors")
    return ready


def case_of(ready: Prepared) -> Case:
    """What is left out of a channel is interpolated: the peers know of no gaps."""
    train, test = (
        [(r.u, filled(r.y)) for r in problem.recordings] for problem in (ready.train, ready.test)
    )
    model = ready.train.model
    return Case(ready.train.sampling_hz, model.inputs, model.outputs, train, test)


def by_process(peer: str, python: str, ready: Prepared) -> dict[str, Any]:
    """Run a peer's script with another Python."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "case.npz"
        save(case_of(ready), path)
        done = subprocess.run(
            [python, HERE / f"diagnosis_peers_{peer}.py", path],
            capture_output=True, text=True, timeout=LIMIT_S, check=False,
        )  # fmt: skip
    if done.returncode:
        return {"failed": done.stderr.strip().splitlines()[-1][:200]}
    return dict(json.loads(done.stdout.splitlines()[-1]))


def by_sysid(ready: Prepared) -> dict[str, Any]:
    import diagnosis_peers_sysid  # needs mujoco[sysid], which the others do not

    return diagnosis_peers_sysid.job(ready)


def one(peer: str, python: str, ready: Prepared) -> dict[str, Any]:
    try:
        return by_sysid(ready) if peer == "mujoco.sysid" else by_process(peer, python, ready)
    except subprocess.TimeoutExpired:
        return {"failed": f"no answer in {LIMIT_S} s"}
    except (TwinError, ValueError, np.linalg.LinAlgError, ImportError) as error:
        return {"failed": f"{type(error).__name__}: {error}"[:200]}


def cases_in(campaign: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield opened cases in the order of their names: name and result."""
    lines = (campaign / "results.jsonl").read_text().splitlines()
    found = (json.loads(line) for line in lines if line.strip())
    kept = {f["name"]: f["result"] for f in found if "truth" in f.get("result", {})}
    yield from sorted(kept.items())


def ours_of(result: dict[str, Any]) -> dict[str, Any]:
    diagnosis = result["diagnosis"]
    first = diagnosis["findings"][0] if diagnosis["findings"] else None
    fit, near = (diagnosis[key]["test"] for key in ("fit", "fit_ahead"))
    return {
        "free": fit["explained"],
        "ahead": near["explained"],
        "says": first and {key: first[key] for key in ("mechanism", "location")},
    }


def right(row: dict[str, Any], method: str) -> bool:
    says = row[method].get("says")
    truth = row["truth"]
    same = says and says["mechanism"] == truth["mechanism"]
    return bool(same and says["location"] == truth["location"])


def table_of(cases: dict[str, Any]) -> Table:
    table = Table("method", "named rightly", "free run", "two seconds ahead", "diverged", "s")
    for method in (OURS, *PEERS):
        rows = [row for row in cases.values() if method in row]
        got = {k: [r[method].get(k) for r in rows] for k in ("free", "ahead", "seconds")}
        # what has no error has an infinite one
        middle = {
            k: float(np.median([np.inf if v is None else v for v in values])) if values else np.nan
            for k, values in got.items()
        }
        named = sum(right(row, method) for row in rows)
        lost = sum(v is None for v in got["free"])
        seconds = f"{middle['seconds']:.0f}" if np.isfinite(middle["seconds"]) else ""
        table.add_row(method, f"{named} of {len(rows)}", f"{middle['free']:.3g}",
                      f"{middle['ahead']:.3g}", str(lost), seconds)  # fmt: skip
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("campaign", type=Path)
    parser.add_argument("--cases", type=int, default=20)
    parser.add_argument("--every", type=int, default=1, help="take each so manieth case")
    parser.add_argument("--peers", nargs="+", choices=PEERS, default=PEERS)
    parser.add_argument("--python", default=sys.executable, help="of pysindy and sysidentpy")
    parser.add_argument("--json", type=Path, default=RESULTS)
    chosen = parser.parse_args()
    kept: dict[str, Any] = {"feature": FEATURE, "cases": {}}
    if chosen.json.is_file():
        kept = json.loads(chosen.json.read_text())
    taken = 0
    for name, result in list(cases_in(chosen.campaign))[:: chosen.every]:
        if taken == chosen.cases:
            break
        try:
            ready = ready_of(chosen.campaign / "recordings" / name)
        except TwinError as error:
            print(f"left out: {error}", flush=True)
            continue
        taken += 1
        truth = {key: result["truth"][key] for key in ("mechanism", "location")}
        row = kept["cases"].setdefault(name, {"truth": truth, OURS: ours_of(result)})
        for peer in chosen.peers:
            if peer not in row:
                row[peer] = one(peer, chosen.python, ready)
                text = json.dumps(kept, indent=1) + "\n"
                write_whole(chosen.json, lambda part, text=text: part.write_text(text))
                print(name, truth["mechanism"], peer, json.dumps(row[peer]), flush=True)
    Console().print(table_of(kept["cases"]))


if __name__ == "__main__":
    main()
