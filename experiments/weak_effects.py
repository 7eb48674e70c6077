"""What stated probabilities in the middle are worth: effects so weak that they are confused.

    python experiments/weak_effects.py FOLDER [--budget MINUTES] [--workers N]

The concealed cases are mostly too clear for a probability in the middle. Here effects of the
detection limits are tried at every place that they can have, on rigs, plans and noises of their
own, at severities about the theoretical limit, where one is confused with another. FOLDER keeps
what is done; run it again to go on. Writes experiments/results/weak_effects.json; what another
version has found there is kept as an earlier run.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from experiments.concealed.calibration import calibration_curve  # noqa: E402
from experiments.concealed.pictures import between, percent  # noqa: E402
from experiments.detection_limits import CONDITIONS, TITLE, Task, diagnosed  # noqa: E402
from experiments.detection_limits_theory import PAIRS  # noqa: E402
from experiments.in_pieces import commit_of, pieces  # noqa: E402

RESULT = "weak_effects"

SEVERITIES = {
    "coulomb_friction": (1.0, 1.2, 1.4),
    "cubic_stiffness": (1.0, 1.4, 1.7),
    "quadratic_stiffness": (1.0, 1.1, 1.2),
    "quadratic_drag": (0.8, 1.0, 1.2),
    "stiffness_drift": (1.4, 2.0, 2.8),
    "appendage": (0.9, 1.0, 1.2),
    "sensor_delay": (0.8, 1.0, 1.2),
    "clearance": (1.4, 2.0, 2.8),
}
"""Multiples of the theoretical limit about which probabilities in the middle are stated, as earlier
runs at 0.8 to 4 times the limit showed; a gain of an accelerometer is a tie at any, and a high-pass
filter at none."""

FIRST_TURN = 401
"""Draws of the rig, the plan and the noise: none that the detection limits or a run before used."""

TURNS = 6


def main() -> None:
    with pieces(__doc__, TITLE) as work:
        cases = work.done(diagnosed, tasks(), "cases")
    earlier = before(work.results / f"{RESULT}.json", work.made_with)
    found = {"made_with": work.made_with, "cases": cases, "earlier": earlier}
    path = work.write(found, RESULT)
    stated = [(c["probability"], c["found"]) for c in cases if c["probability"] is not None]
    for one in calibration_curve(stated):
        right = one["right"]
        print(
            f"{one['from']:4g} to {one['to']:4g}: stated {one['probability']:.3f}, right "
            f"{right['count']:3d} of {right['of']:3d}, {percent(right['share'])} ({between(right)})"
        )
    print(path)


def tasks() -> list[Task]:
    """Return all cases, in an order that is of use wherever it is cut off."""
    return [
        Task(replace(pair, place=f"{pair.place[:-1]}{at}"), SEVERITIES[pair.name][step],
             *CONDITIONS[0], turn)
        for turn, step, at in product(range(FIRST_TURN, FIRST_TURN + TURNS), range(3), (1, 2))
        for pair in PAIRS
        if pair.name in SEVERITIES
    ]  # fmt: skip


def before(path: Path, made_with: Mapping[str, str]) -> list[dict[str, Any]]:
    """Return the runs of other versions that a file of results holds, the latest first."""
    if not path.exists():
        return []
    last = json.loads(path.read_text())
    earlier: list[dict[str, Any]] = last.pop("earlier", [])
    runs = [last, *earlier]
    return [run for run in runs if commit_of(run["made_with"]) != commit_of(made_with)]


if __name__ == "__main__":
    main()
