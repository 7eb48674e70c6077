"""Dry friction on a frame: what the analyser's filter is worth, and whether the steps are enough.

The shipped two-storey frame with dry friction in its second storey, simulated by MuJoCo, shaken and
hit, 0.5 % noise behind the laboratory's analyser. Friction there is fitted twice, each from twice
its force and a wide change of sign: its law following the estimated motion and seen as it is, and
its law simulated and seen through a filter; with 4 to 32 parts of a sample.

    python -m experiments.friction_likelihood [--parts 4 8 16 32]

Prints a table: log evidence [nat], the force found over the true one, and seconds.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from experiments.closure_rigs import STRUCTURES, record
from experiments.closure_sizes import visible
from twin.diagnosis.beginning import added, beginnings, likeliest, moved_to, start_of
from twin.diagnosis.candidates import Candidate, motions, priors_of, scales_of, surroundings
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.diagnosis.problem import LINEAR_PHASE
from twin.estimation.fit import fit
from twin.formats import read_recording
from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.model import Twin

CHAIN = STRUCTURES["chain"]
TOLERANCE, STEPS = 0.004, 40


@dataclass(frozen=True)
class Stepped(Hypothesis):
    """A hypothesis whose laws are stepped in so many parts of a sample."""

    parts: int = 4

    def _parts(self, scales: np.ndarray) -> int:
        return self.parts


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--parts", type=int, nargs="+", default=[4, 8, 16, 32])
    given = parser.parse_args()
    true = visible(CHAIN, "coulomb_friction")
    with tempfile.TemporaryDirectory() as folder:
        train, test = record(CHAIN, true, Path(folder))
        ready = prepare(
            Twin.load(CHAIN.model), [read_recording(p) for p in train],
            [read_recording(p) for p in test], TOLERANCE,
        )  # fmt: skip
    problem, place = ready.train, true.place
    empty = Hypothesis(problem)
    nothing = fit(empty, start_of(empty))
    moved = motions(problem, empty, nothing.z)
    starts = CoulombFriction.starts(place, surroundings(problem, moved, place))
    candidate = Candidate(starts, priors_of(starts))
    first = replace(starts[-1], sliding_force=2 * true.values["force"])
    print(
        "| law | parts of a sample | log evidence [nat] | force / true force | s |\n|" + "---|" * 5
    )
    for name, low_pass in (("follows the motion", None), ("simulated", LINEAR_PHASE)):
        for parts in given.parts:
            here = Stepped(replace(problem, low_pass=low_pass), scales=scales_of(problem, moved),
                           parts=parts)  # fmt: skip
            grown = added(here, candidate, first)
            z = moved_to(grown, empty, nothing.z, first)
            begin = time.perf_counter()
            found = fit(grown, likeliest(grown, [z, *beginnings(grown, z)])[1], STEPS)
            seconds = time.perf_counter() - begin
            share = found.values[f"coulomb_friction {place} force"] / true.values["force"]
            print(f"| {name} | {parts} | {found.log_evidence:.0f} | {share:.4f} | {seconds:.0f} |",
                  flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
