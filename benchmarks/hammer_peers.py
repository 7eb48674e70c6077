"""Damping of a metal part's modes: ours, sdypy-EMA's and pyOMA2's, and which of them is right.

    pip install sdypy-EMA pyOMA-2
    python benchmarks/hammer_peers.py ../shared/data/hammer_part [--only PART] [--json FILE]
    python benchmarks/hammer_peers.py --show benchmarks/results/hammer_peers.json

First on the measured hits, each alone and all three together: every package's value is the median
of the stable poles near the mode over all orders of its diagram; the spread is the range of those
medians over packages and hits. Then which package's modes foresee a hit that was not fitted
(``hammer_unseen.py``). Then on parts whose modes are known, hit with the measured forces
(``hammer_known.py``): one has the damping that is found here, one that which sdypy-EMA finds.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import hammer_tables
import numpy as np
from hammer_known import Part, forces, like
from hammer_poles import NEAR, PEERS, Picked, Poles, picked
from hammer_unseen import unseen
from machine import described
from numpy.typing import NDArray
from rich.console import Console

sys.path.insert(0, str(Path(__file__).parents[1] / "experiments"))

from hammer_part import BAND, NAMES, PEER_HZ, RATE

from twin.formats import read_recording
from twin.identification.identify import identify
from twin.modal import ModalModel
from twin.recording import Recording

Array = NDArray[np.float64]

OURS = "ours"
EMA = "sdypy-EMA LSCF"


def measured(hits: Sequence[Recording]) -> list[dict[str, Any]]:
    """Return what every package finds of every mode: {mode, values: {package: {hits: Picked}}}."""
    chosen = {str(i + 1): [hit] for i, hit in enumerate(hits)} | {"all": list(hits)}
    poles = {name: {of: peer(some, BAND) for of, some in chosen.items()}
             for name, peer in PEERS.items()}  # fmt: skip
    own = {of: identify(some, band_hz=BAND).modal for of, some in chosen.items()}
    rows = []
    for f in PEER_HZ:
        values = {name: {of: _entry(picked(p, f)) for of, p in each.items()}
                  for name, each in poles.items()}  # fmt: skip
        values[OURS] = {of: nearest(modal, f) for of, modal in own.items()}
        rows.append({"mode": f, "values": values})
    return rows


def known(part: Part, drives: Sequence[Array], draws: int) -> list[dict[str, Any]]:
    """Return each package's damping of the modes of a known part, one value per draw."""
    true = [int(np.argmin(np.abs(part.frequency_hz - f))) for f in PEER_HZ]
    rows: list[dict[str, Any]] = [
        {"mode": float(part.frequency_hz[i]), "true": float(part.damping[i]),
         "values": {name: [] for name in (OURS, *PEERS)}}
        for i in true
    ]  # fmt: skip
    for seed in range(draws):
        hits = part.hits(drives, RATE, seed)
        modal = identify(hits, band_hz=BAND).modal
        poles: dict[str, Poles] = {name: peer(hits, BAND) for name, peer in PEERS.items()}
        for row in rows:
            row["values"][OURS].append(nearest(modal, row["mode"]))
            for name, found in poles.items():
                row["values"][name].append(_entry(picked(found, row["mode"])))
    return rows


def nearest(modal: ModalModel, frequency_hz: float) -> dict[str, float] | None:
    """Return the mode near a frequency, or None."""
    i = int(np.argmin(np.abs(modal.natural_freq - frequency_hz)))
    if abs(modal.natural_freq[i] / frequency_hz - 1) > NEAR:
        return None
    assert modal.damping_ratio_std is not None
    return {
        "frequency_hz": float(modal.natural_freq[i]), "damping": float(modal.damping_ratio[i]),
        "std": float(modal.damping_ratio_std[i]),
    }  # fmt: skip


def _entry(found: Picked | None) -> dict[str, float] | None:
    return None if found is None else asdict(found)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, nargs="?", help="folder with hit1.csv, hit2.csv, ...")
    parser.add_argument("--only", choices=("measured", "unseen", "known"), help="this part alone")
    parser.add_argument("--draws", type=int, default=5, help="of the noise of a known part")
    parser.add_argument("--json", type=Path, help="file for the results")
    parser.add_argument("--show", type=Path, help="results to print; nothing is measured then")
    options = parser.parse_args()
    console = Console(width=None if Console().is_terminal else 120)
    if options.show:
        hammer_tables.show(console, json.loads(options.show.read_text(encoding="utf-8")))
        return
    files = sorted(options.folder.glob("hit*.csv")) if options.folder else []
    if not files:
        parser.error("the folder of the hits is needed, or results to --show")
    hits = [read_recording(file, NAMES, RATE) for file in files]
    kept = options.json is not None and options.json.exists()
    found: dict[str, Any] = json.loads(options.json.read_text(encoding="utf-8")) if kept else {}
    wanted = ("measured", "unseen", "known") if options.only is None else (options.only,)
    found |= {"machine": described()}
    if "measured" in wanted or "measured" not in found:
        found["measured"] = measured(hits)
    if "unseen" in wanted:
        found["unseen"] = unseen(hits, found["measured"], OURS, BAND)
    if "known" in wanted:
        found["draws"] = options.draws
        part, drives = like(hits, identify(hits)), forces(hits)
        ema = {row["mode"]: row["values"][EMA]["all"] for row in found["measured"]}
        theirs = {f: value["damping"] for f, value in ema.items() if value is not None}
        other = part.damped(np.array(list(theirs)), np.array(list(theirs.values())))
        found["known"] = {
            "our damping": known(part, drives, options.draws),
            "sdypy-EMA's damping": known(other, drives, options.draws),
        }
    if options.json:
        options.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    hammer_tables.show(console, found)


if __name__ == "__main__":
    main()
