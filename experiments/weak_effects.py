"""What stated probabilities in the middle are worth: effects so weak that they are confused.

    python experiments/weak_effects.py FOLDER [--budget MINUTES] [--workers N]

The concealed cases are mostly too clear for a probability in the middle. Here every effect of the
detection limits is tried at every place that it can have, on rigs, plans and noises of their own,
at severities about the theoretical limit, where one is confused with another. FOLDER keeps what is
done; run it again to go on. Writes experiments/results/weak_effects.json.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from itertools import product
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from experiments.concealed.calibration import calibration_curve  # noqa: E402
from experiments.concealed.pictures import between, percent  # noqa: E402
from experiments.detection_limits import CONDITIONS, MASKED, TITLE, Task, diagnosed  # noqa: E402
from experiments.detection_limits_theory import PAIRS  # noqa: E402
from experiments.in_pieces import pieces  # noqa: E402

CLEAR = (1.0, 1.4, 2.0)
"""Severities over the theoretical limit at which effects of their own kind are confused."""

CONFUSED = (1.4, 2.8, 4.0)
"""The same of those that are confused with themselves at another place."""

FIRST_TURN = 101
"""Draws of the rig, the plan and the noise: none that the detection limits have used."""

TURNS = 6


def main() -> None:
    with pieces(__doc__, TITLE) as work:
        cases = work.done(diagnosed, tasks(), "cases")
    path = work.write({"made_with": work.made_with, "cases": cases}, "weak_effects")
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
