"""Instruments that misbehave: is one of them taken for missing physics, or does it hide it?

Rigs simulated by the proof's own integrator; on their training recordings each of fourteen
nuisances at three strengths, alone. Nothing is concealed, and right is: no structural finding;
named is: the channel that has it is among the findings. Or, with --effect, one structural effect of
the table ``single`` is, all mechanisms and places in turn, and right is: the first structural
finding has its mechanism and place; spurious is any structural finding besides.

    python -m experiments.nuisances --draws 2 --to experiments/results/nuisances.json
    python -m experiments.nuisances --draws 2 --effect --strength 1 --only hum

84 cases each in two draws. Resumable: the folder of --out keeps what is done. Prints a table; --to
writes the results beside those of the other kind that the file holds, for ``proof_page.py``.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

import twin
from experiments.concealed.case import case_name, generate
from experiments.concealed.tables import combination_of
from experiments.concealed.versions import versions
from experiments.instrument_faults import AT_SENSOR, NUISANCES, STRENGTHS, Array, Change, Setting
from twin.campaign import campaign
from twin.diagnosis.pipeline import diagnose
from twin.files import write_whole
from twin.recording import Recording

MODEL = "two_storey_lumped"
SEED = 5100
"""Of the cases that count; a set to develop on has another one (--seed)."""
MEASURED = "measurement"
"""Verdict of the mechanisms that are an instrument's."""


@dataclass(frozen=True)
class Task:
    """One nuisance at one strength.

    Attributes:
        name: of the nuisance.
        strength: of it.
        number: of the case.
        folder: that keeps recordings and truths.
        table: of the case: "none", or "single" where an effect is concealed.
        seed: of the campaign.
    """

    name: str
    strength: float
    number: int
    folder: Path
    table: str = "none"
    seed: int = SEED


def tasks(
    names: list[str],
    strengths: list[float],
    draws: int,
    folder: Path,
    effect: bool,
    seed: int = SEED,
) -> dict[str, Task]:
    """Return the cases by name; the number of each does not depend on what else is asked for.

    Every case with an effect has one of its own; the strengths share a sound rig.
    """
    every, found = list(NUISANCES), {}
    for draw in range(draws):
        for name in names:
            for strength in strengths:
                number = draw * len(every) + every.index(name)
                if effect:
                    turn = number * len(STRENGTHS) + STRENGTHS.index(strength)
                    number = structural_number(turn, seed)
                else:
                    number += 1
                key = f"{name}, {strength:g}" + (f", draw {draw + 1}" if draw else "")
                table = "single" if effect else "none"
                found[key] = Task(name, strength, number, folder, table, seed)
    return found


def structural_number(turn: int, seed: int = SEED) -> int:
    """Return the number of the case of ``single`` with the turn-th structural effect, from 0."""
    return next(number for i, number in enumerate(_structural(seed)) if i == turn)


def _structural(seed: int) -> Iterator[int]:
    number = 0
    while True:
        number += 1
        (name, _), *_ = combination_of("single", number, seed)
        if not name.startswith("sensor_"):
            yield number


def work(task: Task) -> dict[str, Any]:
    """Return the verdict, the findings and how long it took."""
    case = case_name(task.number, task.table)
    sound = task.folder / "recordings"
    made(task, sound)
    change, at_sensor = NUISANCES[task.name][0], task.name in AT_SENSOR
    spoilt = task.folder / f"{task.name} {task.strength:g}" if at_sensor else sound
    if at_sensor:
        made(task, spoilt, partial(_sensors, change, task.strength))

    def faulty(path: Path) -> Recording:
        recording = twin.read(path)
        if at_sensor:
            return recording
        columns = {n: np.array(recording.column(n)) for n in recording.names}
        draw = np.random.default_rng([task.seed, task.number, len(path.name), ord(path.stem[-1])])
        setting = Setting(task.strength, recording.sampling_hz, draw)
        return Recording.build(recording.sampling_hz, change(columns, setting), recording.source)

    train = [faulty(p) for p in sorted((spoilt / case).glob("train_*.csv"))]
    test = [twin.read(p) for p in sorted((sound / case).glob("test_*.csv"))]
    found = diagnose(twin.Twin.load(MODEL), train, test)
    places = [(f.mechanism.name, f.location) for f in found.findings]
    scored = score(task, places, found.notes)
    return {"verdict": found.verdict, **scored, "seconds": round(found.seconds)}


def made(task: Task, folder: Path, sensors: Callable[[Array, float], Array] | None = None) -> None:
    """Write the recordings of a task's case into a folder that has not got them.

    Args:
        task: its case.
        folder: gets them.
        sensors: what the accelerometers do to the accelerations.
    """
    case = case_name(task.number, task.table)
    if not (folder / case / "test_2.csv").exists():
        sealed = task.folder / "sealed"
        generate(task.number, task.seed, folder, sealed, task.table, sensors=sensors)


def _sensors(change: Change, strength: float, accelerations: Array, rate: float) -> Array:
    """Return the accelerations, (samples, floors), as faulty sensors give them."""
    columns = {f"acc_floor{i}": x for i, x in enumerate(accelerations.T, 1)}
    given = change(columns, Setting(strength, rate, np.random.default_rng(0)))
    return np.column_stack(list(given.values()))


def score(task: Task, places: list[tuple[str, str]], notes: Any) -> dict[str, Any]:
    """Return what was said of the structure and of the channel.

    Args:
        task: the case.
        places: mechanism and place of every finding, in order.
        notes: of the diagnosis.
    """
    channels = NUISANCES[task.name][1]
    structural = [p for p in places if vocabulary_verdict(p[0]) != MEASURED]
    named = {c for _, place in places for c in place.split("+")} & set(channels)
    noted = {c for c in channels if any(c in note for note in notes)}
    said = ", ".join(f"{a} {b}" for a, b in places) or "nothing"
    result = {"said": said, "structural": len(structural), "named": bool(named),
              "noted": bool(named | noted)}  # fmt: skip
    if task.table == "none":
        return {**result, "right": not structural}
    (effect,) = combination_of("single", task.number, task.seed)
    spurious = sum(p != effect for p in structural)
    return {**result, "concealed": " ".join(effect), "right": structural[:1] == [effect],
            "spurious": spurious}  # fmt: skip


def vocabulary_verdict(name: str) -> str:
    """Return the verdict of a mechanism by its name."""
    from twin.mechanisms import vocabulary

    return vocabulary()[name].verdict


def table(results: Mapping[str, Mapping[str, Any]], effect: bool = False) -> str:
    """Return the results as Markdown."""
    first = ["nuisance, strength", *(["concealed"] if effect else []), "said", "right"]
    columns = [*first, "spurious" if effect else "channel named", "s"]
    lines = [f"| {' | '.join(columns)} |", "|" + "---|" * len(columns)]
    for name, r in results.items():
        right = "yes" if is_right(r) else "no"
        named = "yes" if r["named"] else "in a note" if r["noted"] else "no"
        cells = [name, *([r["concealed"]] if effect else []), r["said"], right,
                 str(r["spurious"]) if effect else named, str(r["seconds"])]  # fmt: skip
        lines.append(f"| {' | '.join(cells)} |")
    right, total = sum(map(is_right, results.values())), len(results)
    if effect:
        alone = sum(not r["spurious"] for r in results.values())
        lines.append(f"\n{right} of {total} with mechanism and place first, "
                     f"{alone} without a spurious structural finding.")  # fmt: skip
    else:
        named = sum(r["noted"] for r in results.values())
        lines.append(f"\n{right} of {total} without a structural finding, "
                     f"{named} with the channel named or noted.")  # fmt: skip
    return "\n".join(lines)


def is_right(result: Mapping[str, Any]) -> bool:
    """Return whether a case is right; results of earlier versions say how many findings."""
    return bool(result["right"] if "right" in result else not result["structural"])


def keep(
    path: Path, kind: str, results: Mapping[str, Mapping[str, Any]], seed: int = SEED
) -> None:  # fmt: skip
    """Write the results of a kind ("none", "effect") beside those of the other."""
    document = json.loads(path.read_text()) if path.exists() else {}
    cases = [{"case": name, **r, "right": is_right(r)} for name, r in results.items()]
    document[kind] = {"made_with": versions(), "seed": seed, "cases": cases}
    text = json.dumps(document, indent=1, allow_nan=False) + "\n"
    write_whole(path, lambda part: part.write_text(text))


def main() -> None:
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("nuisances"))
    parser.add_argument("--strength", type=float, action="append", choices=STRENGTHS)
    parser.add_argument("--only", action="append", choices=list(NUISANCES))
    parser.add_argument("--draws", type=int, default=1, help="of each nuisance and strength")
    parser.add_argument("--effect", action="store_true", help="conceal one structural effect")
    parser.add_argument("--seed", type=int, default=SEED, help="of another set of cases")
    parser.add_argument("--to", type=Path, help="JSON, for the proof's page")
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    every = tasks(given.only or list(NUISANCES), given.strength or list(STRENGTHS), given.draws,
                  given.out, given.effect, given.seed)  # fmt: skip
    kind = "effect" if given.effect else "none"
    file = given.out / ("effects.jsonl" if given.effect else "results.jsonl")
    identity = "effects under nuisances" if given.effect else "nuisances"
    identity += "" if given.seed == SEED else f", seed {given.seed}"
    with ProcessPoolExecutor(given.workers, mp_context=get_context("spawn")) as pool:
        results = campaign(work, every, pool, file, identity,
                           lambda done, total: print(f"{done} of {total}", flush=True))  # fmt: skip
    print(table(results, given.effect))
    if given.to:
        keep(given.to, kind, results, given.seed)


if __name__ == "__main__":
    main()
