"""Are the limits of ``twin rehearse`` met: fresh effects at one and a half times what it states.

    python experiments/rehearsed.py FOLDER [--cases 40] [--workers 2]

A test of the portal in space is rehearsed; then effects are drawn among those with a limit, one
mechanism after the other, concealed at 1.5 times their limit with excitation and noise of their
own, and diagnosed. FOLDER keeps what is done; run it again to go on. Writes
experiments/results/rehearsed.json.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from concurrent.futures import Executor, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from twin.campaign import campaign  # noqa: E402
from twin.files import write_whole  # noqa: E402
from twin.model import Twin  # noqa: E402
from twin.rehearsal.bench import Bench  # noqa: E402
from twin.rehearsal.plan import Plan, plan_of  # noqa: E402
from twin.rehearsal.rehearse import Case, diagnosed, first_named, rehearse  # noqa: E402
from twin.rehearsal.result import Limit  # noqa: E402

MODEL = "portal_3d"
SEED = 20
TIMES = 1.5
CASES = 40
WANTED = 0.9
"""Share of the fresh cases that must be named first, mechanism and place."""

_SHAKEN = {
    "kind": "shaker", "at": ["force_floor1_x", "force_floor2_y"], "level": 1.0,
    "band_hz": [0.5, 20], "duration_s": 16, "rate_hz": 64, "use": "train",
}  # fmt: skip
PLAN: dict[str, Any] = {
    "tolerance": 0.01,
    "noise": {"acc": 0.005, "force": 0.005},
    "recordings": [
        _SHAKEN,
        {**_SHAKEN, "level": 0.4},
        {**_SHAKEN, "level": 0.7, "use": "test"},
    ],
}
"""Two shakers at once, strong and weak, half a per cent of noise, a drawing good for a per cent."""


def drawn(limits: tuple[Limit, ...], cases: int, rng: np.random.Generator) -> list[Limit]:
    """Draw effects that have a limit, each mechanism as often as any other, none twice."""
    left: dict[str, list[Limit]] = {}
    for limit in limits:
        if limit.times is not None:
            left.setdefault(limit.mechanism, []).append(limit)
    found: list[Limit] = []
    while left and len(found) < cases:
        for name in rng.permutation(sorted(left)).tolist():
            found.append(left[name].pop(int(rng.integers(len(left[name])))))
            if not left[name]:
                del left[name]
    return found[:cases]


def study(
    twin: Twin, plan: Plan, cases: int, executor: Executor | None, results: Path | None
) -> dict[str, Any]:
    """Rehearse, conceal at 1.5 times the limits, diagnose and count.

    Returns:
        rows: one a case; found, of: how many were named first.
    """
    limits = rehearse(twin, plan, seed=SEED).limits
    bench = Bench.of(twin, plan, SEED)
    effects = {effect.label: effect for effect in bench.effects}
    picked = drawn(limits, cases, np.random.default_rng(SEED))
    tasks = {}
    for number, limit in enumerate(picked):
        effect = effects[limit.mechanism, limit.place]
        assert limit.times is not None
        concealed = effect.at(TIMES * limit.times if effect.sized else limit.times)
        tasks[effect.title] = Case(twin, plan, concealed, SEED + 1 + number)
    answers = campaign(diagnosed, tasks, executor, results, f"rehearsed {SEED}", _told)
    rows = []
    for limit, (title, answer) in zip(picked, answers.items(), strict=True):
        label = limit.mechanism, limit.place
        right, said = first_named(answer, label, bench.model)
        size = effects[label].size(limit.times * (TIMES if effects[label].sized else 1.0))
        rows.append({"effect": title, "limit": limit.in_words, "size": size, "found": right,
                     "said": said, "seconds": answer["seconds"]})  # fmt: skip
    return {"rows": rows, "found": sum(row["found"] for row in rows), "of": len(rows)}


def _told(done: int, of: int) -> None:
    print(f"{done} of {of} diagnosed", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    twin, plan = Twin.load(MODEL), plan_of(PLAN)
    with ProcessPoolExecutor(given.workers, get_context("spawn")) as executor:
        found = study(twin, plan, given.cases, executor, given.folder / "rehearsed.jsonl")
    for row in found["rows"]:
        print("found " if row["found"] else "missed", row["effect"], row["limit"], "|", row["said"])
    enough = "met" if found["found"] >= WANTED * found["of"] else "not met"
    print(f"{found['found']} of {found['of']} at {TIMES} times the limit: {enough}")
    text = json.dumps({"plan": PLAN, "seed": SEED, **found}, indent=1) + "\n"
    path = ROOT / "experiments" / "results" / "rehearsed.json"
    write_whole(path, lambda part: part.write_text(text))


if __name__ == "__main__":
    main()
