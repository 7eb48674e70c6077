"""What stated probabilities in the middle are worth: effects so weak that they are confused.

    python experiments/weak_effects.py FOLDER [--budget MINUTES] [--workers N]

The concealed cases are mostly too clear for a probability in the middle. Here every effect of the
detection limits is tried at every place that it can have, on rigs, plans and noises of their own,
at severities about the theoretical limit, where one is confused with another. FOLDER keeps what is
done; run it again to go on. Writes experiments/results/weak_effects.json.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from dataclasses import replace
from itertools import product
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from experiments.concealed.calibration import calibration_curve  # noqa: E402
from experiments.concealed.pictures import between, percent  # noqa: E402
from experiments.detection_limits import (  # noqa: E402
    CONDITIONS,
    MASKED,
    Task,
    diagnosed,
    read,
    run,
    started_with,
)
from experiments.detection_limits_theory import PAIRS  # noqa: E402
from twin.files import folder, write_whole  # noqa: E402

CLEAR = (1.0, 1.4, 2.0)
"""Severities over the theoretical limit at which effects of their own kind are confused."""

CONFUSED = (1.4, 2.8, 4.0)
"""The same of those that are confused with themselves at another place."""

FIRST_TURN = 101
"""Draws of the rig, the plan and the noise: none that the detection limits have used."""

TURNS = 6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--budget", type=float, default=float("inf"), help="minutes")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--results", type=Path, default=ROOT / "experiments" / "results")
    given = parser.parse_args()
    until = time.time() + 60 * given.budget
    out = folder(given.folder)
    made_with = started_with(out / "made_with.json", given.budget > 0)
    pool = ProcessPoolExecutor(given.workers) if given.workers > 1 else nullcontext()
    with pool as executor:
        run(diagnosed, tasks(), out / "cases.jsonl", executor, given.workers, until)
    cases = list(read(out / "cases.jsonl").values())
    found = {"made_with": made_with, "cases": cases}
    text = json.dumps(found, indent=1, allow_nan=False) + "\n"
    path = write_whole(given.results / "weak_effects.json", lambda part: part.write_text(text))
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
        Task(replace(pair, place=f"{pair.place[:-1]}{at}"), severities[step], *CONDITIONS[0], turn)
        for turn, step, at in product(range(FIRST_TURN, FIRST_TURN + TURNS), range(3), (1, 2))
        for pair in PAIRS
        for severities in [CONFUSED if pair.name in MASKED else CLEAR]
    ]


if __name__ == "__main__":
    main()
