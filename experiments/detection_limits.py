"""The weakest effect that ``twin diagnose`` names, beside the weakest that any test could.

    python experiments/detection_limits.py FOLDER [--budget MINUTES] [--workers N]

Each case is a frame as built, a plan, a chain and a noise of its own, drawn as the concealed cases
are, and one effect whose severity is a multiple of the theoretical limit of that very case. FOLDER
keeps what is done; run it again to go on. Writes experiments/results/detection_limits.json.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from experiments.concealed.chain import measure  # noqa: E402
from experiments.concealed.motions import motion  # noqa: E402
from experiments.concealed.score import pair_of, words  # noqa: E402
from experiments.concealed.steps import TOLERANCE  # noqa: E402
from experiments.detection_limits_report import document, show  # noqa: E402
from experiments.detection_limits_rivals import nearest  # noqa: E402
from experiments.detection_limits_theory import PAIRS, Bench, Pair  # noqa: E402
from experiments.in_pieces import commit_of, pieces  # noqa: E402
from twin.formats import write_recording  # noqa: E402

SEED = 5
TITLE = f"detection limits of seed {SEED}"
MULTIPLES = (0.7, 1.0, 1.4, 2.0, 2.8)
"""Severities over the theoretical limit; all of them are tried in the first condition only.

There the curve was seen to rise between 1 and 2.8: the others are spent on that.
"""

CONDITIONS = ((0.005, 1.0), (0.015, 1.0), (0.005, 1 / 3))
"""Noise as a share of RMS, length of the recordings as a share of the campaign's 24 to 30 s."""

MASKED = (
    "coulomb_friction", "cubic_stiffness", "stiffness_drift", "clearance", "sensor_gain",
)  # fmt: skip
STRONGER = (4.0, 5.6)
"""Effects that any test confuses with themselves at another place are tried stronger, too."""

ROUNDS = 3
NOISES = (0.002, 0.003, 0.005, 0.008, 0.01, 0.015, 0.02, 0.03)
LENGTHS_S = (5.0, 7.0, 9.0, 12.0, 16.0, 21.0, 27.0, 30.0)
DRAWS = 3
"""A theoretical curve is the median of so many rigs and plans."""


@dataclass(frozen=True)
class Task:
    """A case: which effect, at what multiple of its limit, in which condition."""

    pair: Pair
    multiple: float
    noise: float
    length: float
    turn: int

    @property
    def name(self) -> str:
        """All that decides the result."""
        return (
            f"{self.pair.title} x{self.multiple:g} noise {self.noise:g} "
            f"length {self.length:.2f} turn {self.turn}"
        )


@dataclass(frozen=True)
class CurveTask:
    """A point of the theoretical curves, for all pairs, of one rig and plan."""

    noise: float
    seconds: float
    draw: int

    @property
    def name(self) -> str:
        """All that decides the result."""
        return f"limit noise {self.noise:g} seconds {self.seconds:g} draw {self.draw}"


def main() -> None:
    with pieces(__doc__, TITLE) as work:
        rows = work.done(diagnosed, tasks(), "cases")
        # the limits are cheap: they are not cut short
        theory = [
            work.done(limits, curve_tasks(), "limits", cut_short=False),
            work.done(rivals, rival_tasks(), "rivals", cut_short=False),
        ]
    found = document(rows, *theory)
    found["made_with"] = work.made_with
    found["text"] += f"\n\nDiagnosed with commit {commit_of(work.made_with)}."
    path = work.write(found, "detection_limits")
    show(found)
    print(path)


def tasks() -> list[Task]:
    """Return all cases, in an order that is of use wherever it is cut off."""
    first, *others = CONDITIONS
    one_turn = [(by, first) for by in (*MULTIPLES, *STRONGER)]
    one_turn += list(product((*MULTIPLES[2:], *STRONGER[:1]), others))
    return [
        Task(pair, by, *condition, turn)
        for turn in range(1, ROUNDS + 1)
        for by, condition in one_turn
        for pair in PAIRS
        if by not in STRONGER or pair.name in MASKED
    ]


def curve_tasks() -> list[CurveTask]:
    """Return the points of the theoretical curves: against noise, and against length."""
    noise = CONDITIONS[0][0]
    points = [(one, 0.0) for one in NOISES] + [(noise, seconds) for seconds in LENGTHS_S]
    return [CurveTask(*point, draw) for draw in range(1, DRAWS + 1) for point in points]


def rival_tasks() -> list[CurveTask]:
    """Return the rigs and plans on which the nearest rivals are looked for."""
    return [CurveTask(CONDITIONS[0][0], 0.0, draw) for draw in range(1, DRAWS + 1)]


def diagnosed(task: Task) -> dict[str, Any]:
    """Make a case, diagnose it and say whether mechanism and place were named first."""
    rng = np.random.default_rng([SEED, crc32(task.name.encode())])
    bench = Bench.draw(rng, task.noise, task.length)
    limit = bench.limit(task.pair)
    effect = bench.effect(task.pair, limit * task.multiple)
    with tempfile.TemporaryDirectory(prefix="twin-") as name:
        for test in bench.plan:
            drive, seen, _ = motion(bench.rig, [effect], test, bench.chain.fine)
            recorded = bench.rehearsal.recorded
            recording = measure(bench.chain, test, drive, seen, [effect], recorded, rng)
            write_recording(recording, Path(name) / f"{test.name}.csv")
        began = time.perf_counter()
        said = _said(bench.rig.model, Path(name))
    first = said["findings"][0] if said.get("findings") else None
    return {
        "mechanism": task.pair.name,
        "place": task.pair.place,
        "multiple": task.multiple,
        "severity": limit * task.multiple,
        "limit": limit,
        "noise": task.noise,
        "length": task.length,
        "seconds_recorded": float(np.mean([test.duration_s for test in bench.plan[:4]])),
        "turn": task.turn,
        "found": first is not None and pair_of(first) == (task.pair.name, task.pair.place),
        "first": words(pair_of(first)) if first else said.get("error", "none"),
        "probability": first["probability"] if first else None,
        "verdict": said.get("verdict", ""),
        "rank": _rank(task.pair, said),
        "seconds": time.perf_counter() - began,
    }


def _said(model: str, recordings: Path) -> Mapping[str, Any]:
    """Return the JSON of ``twin diagnose``; an error is a miss."""
    from twin.cli.diagnose import diagnose_files

    train, test = (sorted(recordings.glob(f"{kind}_*.csv")) for kind in ("train", "test"))
    try:
        return diagnose_files(model, train, test, None, 0, TOLERANCE)
    except Exception as error:  # whatever it is
        return {"error": f"{type(error).__name__}: {error}"}


def _rank(pair: Pair, said: Mapping[str, Any]) -> int | None:
    """Return the place of the effect among findings and alternatives, from 1."""
    every = [*said.get("findings", []), *said.get("alternatives", [])]
    named = [pair_of(entry) for entry in every]
    wanted = (pair.name, pair.place)
    return named.index(wanted) + 1 if wanted in named else None


def limits(task: CurveTask) -> dict[str, Any]:
    """Return the theoretical limits of all pairs at one noise and length [SI units]."""
    bench = Bench.draw(np.random.default_rng([SEED, task.draw]), task.noise, 1.0, task.seconds)
    return {
        "noise": task.noise,
        "seconds": task.seconds,
        "draw": task.draw,
        "limits": {pair.title: bench.limit(pair) for pair in PAIRS},
    }


def rivals(task: CurveTask) -> dict[str, Any]:
    """Return the nearest rival of every pair at its limit and the nats between the two."""
    rng = np.random.default_rng([SEED, task.draw])
    bench = Bench.draw(rng, task.noise, 1.0, task.seconds)
    return {"draw": task.draw, "rivals": nearest(bench, rng)}


if __name__ == "__main__":
    main()
