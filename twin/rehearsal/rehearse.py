"""The rehearsal: limits predicted for every effect, then verified by whole diagnoses.

A diagnosis is tried at the predicted limit, with excitation and noise of its own. Where the effect
is not named first, the next is twice as large; where it is, the next is as large again, until the
second success in a row. Twice the size is four times the evidence.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, replace
from math import inf, isfinite
from pathlib import Path
from time import perf_counter
from typing import Any
from zlib import crc32

from twin.api import diagnose
from twin.campaign import campaign
from twin.errors import TwinError
from twin.files import check_folder
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Mechanism
from twin.model import Twin
from twin.model.linear import LinearModel
from twin.rehearsal.bench import Bench
from twin.rehearsal.effects import Effect
from twin.rehearsal.plan import Plan, read_plan
from twin.rehearsal.read_off import calibration_limit, read_off_limit
from twin.rehearsal.recordings import recorded
from twin.rehearsal.result import Limit, Rehearsal, Status, Try
from twin.rehearsal.sensitivity import Prospect, prospects, same_place
from twin.rehearsal.shares import share_of

STEP = 2.0
"""Growth of a size that was not found."""

CONFIRMED = 2
"""Successes in a row after which a size is taken as found: of a size that is found in half of the
cases, one in four passes."""

RESULTS = "diagnoses.jsonl"

Report = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Case:
    """A diagnosis to be made: what is concealed in which recordings."""

    twin: Twin
    plan: Plan
    mechanism: Mechanism
    seed: int


def rehearse(
    model: Twin | str | Path,
    plan: Plan | str | Path,
    *,
    verify: int = 0,
    executor: Executor | None = None,
    folder: Path | None = None,
    seed: int = 0,
    report: Report = lambda step, done, of: None,
    tell: Callable[[Rehearsal], None] = lambda predicted: None,
) -> Rehearsal:
    """Say which effects a test plan would find in a twin, from which size on, and as what.

    Examples:
        >>> import pathlib, tempfile, twin
        >>> file = pathlib.Path(tempfile.mkdtemp()) / "plan.toml"
        >>> _ = file.write_text('''
        ... [conceal]
        ... mechanisms = ["coulomb_friction"]
        ... [[recordings]]
        ... kind = "hammer"
        ... at = "floor1"
        ... level = 20
        ... duration_s = 8
        ... rate_hz = 64
        ... repeat = 2
        ... use = "train"
        ... [[recordings]]
        ... kind = "hammer"
        ... at = "floor2"
        ... level = 20
        ... duration_s = 8
        ... rate_hz = 64
        ... use = "test"
        ... ''')
        >>> first = twin.rehearse("two_storey_lumped", file).limits[0]
        >>> first.mechanism, first.place, first.status
        ('coulomb_friction', 'storey1', 'predicted')

    Args:
        model: the twin, an MJCF file or the name of a shipped model.
        plan: recordings, sensors, noise and what is to be concealed, or its file.
        verify: diagnoses of each effect at most; 0 predicts only.
        executor: where diagnoses run; None for one after the other, here.
        folder: keeps the diagnoses, so that a rehearsal goes on from there; None keeps nothing.
        seed: of recordings and noise; the same seed, the same result.
        report: told a step, how many of it are done, of how many.
        tell: told the prediction before the first diagnosis.

    Raises:
        TwinError: the twin has no such place or sensor, or the folder holds another rehearsal.
    """
    twin = model if isinstance(model, Twin) else Twin.load(model)
    plan = plan if isinstance(plan, Plan) else read_plan(plan)
    if folder is not None:
        check_folder(folder)
    bench = Bench.of(twin, plan, seed)
    expected = predicted(bench)
    effects = bench.effects
    nothing: dict[int, list[tuple[float, Try]]] = {i: [] for i in range(len(effects))}
    first = _result(bench, expected, nothing, seed)
    if verify < 1:
        return first
    tell(first)
    tries = nothing
    results = None if folder is None else folder / RESULTS
    identity = f"rehearsal {_digest(twin, plan, seed)}"
    for _ in range(verify):
        cases: dict[str, Case] = {}
        asked: dict[str, tuple[int, float]] = {}
        for i, effect in enumerate(effects):
            times = next_size(_ladder(effect, plan, expected[i]), [t for _, t in tries[i]])
            if times is None:
                continue
            name = f"{effect.title} x{times:.8g} try {len(tries[i]) + 1}"
            own = crc32(f"{seed} {name}".encode())
            cases[name] = Case(twin, plan, effect.at(times), own)
            asked[name] = i, times
        if not cases:
            break

        def told(done: int, of: int) -> None:
            report("diagnosing what is concealed", done, of)

        made = campaign(diagnosed, cases, executor, results, identity, told)
        for name, answer in made.items():
            i, times = asked[name]
            tries[i].append((times, _try(effects[i], times, answer, bench)))
    return _result(bench, expected, tries, seed)


def predicted(bench: Bench) -> list[Prospect]:
    """Return what is to be expected of every effect of a bench, in its order.

    What is read off the samples is tried on noisy samples; everything else is Fisher's information.
    """
    found = prospects(bench.model, bench.trials, bench.known, bench.effects, bench.others)
    for i, effect in enumerate(bench.effects):
        if isinstance(effect.reference, ChannelFault) and not effect.reference.fitted:
            limit = read_off_limit(effect, bench.recordings)
            found[i] = Prospect(limit, limit, None)
        elif isinstance(effect.reference, ChannelFault) and effect.sized:
            least = calibration_limit(effect, bench.recordings)
            found[i] = replace(found[i], seen=max(found[i].seen, least),
                               named=max(found[i].named, least))  # fmt: skip
    return found


def next_size(ladder: Callable[[int], float], tries: list[Try]) -> float | None:
    """Return the size to be tried next, None where enough is known.

    Args:
        ladder: size after so many steps up; infinite where it ends.
        tries: what was tried, in its order.
    """
    steps, row = 0, 0
    for one in tries:
        row = row + 1 if one.found else 0
        steps += not one.found
    size = ladder(steps)
    return None if row >= CONFIRMED or not isfinite(size) else size


def diagnosed(case: Case) -> dict[str, Any]:
    """Carry the plan out with an effect, diagnose it, and return what stands first.

    Returns:
        findings as [mechanism, place], verdict and seconds; or the error in words.
    """
    began = perf_counter()
    try:
        unmeasured = isinstance(case.mechanism, Disturbance)
        model = Bench.of(case.twin, case.plan, case.seed).model if unmeasured else None
        made = recorded(case.twin, case.plan, case.seed, case.mechanism, model)
        uses = [test.use for test in case.plan.recordings]
        train, test = (
            [r for r, use in zip(made, uses, strict=True) if use == wanted]
            for wanted in ("train", "test")
        )
        found = diagnose(
            case.twin, train, test, tolerance=case.plan.tolerance,
            damping_tolerance=case.plan.damping_tolerance,
        )  # fmt: skip
    except (TwinError, ValueError, ArithmeticError) as error:
        # no answer is a miss, whatever kept it
        words = f"{type(error).__name__}: {error}".splitlines()[0]
        return {"error": words, "seconds": perf_counter() - began}
    return {
        "verdict": found.verdict,
        "findings": [[f.mechanism.name, f.location] for f in found.findings],
        "seconds": perf_counter() - began,
    }


def _ladder(effect: Effect, plan: Plan, expected: Prospect) -> Callable[[int], float]:
    """Return the sizes to be tried, as multiples of the effect's reference."""
    given = plan.sizes.get(effect.label[0])
    if given is not None and effect.sized:
        multiples = sorted(effect.times(size) for size in given)
        return lambda steps: multiples[steps] if steps < len(multiples) else inf
    if not effect.sized:
        return lambda steps: expected.named if steps == 0 else inf
    return lambda steps: expected.named * STEP**steps


def _try(effect: Effect, times: float, answer: Mapping[str, Any], bench: Bench) -> Try:
    right, said = first_named(answer, effect.label, bench.model)
    return Try(effect.size(times), right, said, answer["seconds"])


def first_named(
    answer: Mapping[str, Any], label: tuple[str, str], model: LinearModel
) -> tuple[bool, str]:
    """Return whether mechanism and place stand first in an answer, and what stands there in words.

    Args:
        answer: what ``diagnosed`` returned.
        label: the mechanism that is concealed, and its place.
        model: whose ports the places are.
    """
    if "error" in answer:
        return False, str(answer["error"])
    if not answer["findings"]:
        return False, "nothing"
    name, place = answer["findings"][0]
    right = name == label[0] and same_place(place, label[1], model)
    return right, f"{name} at {place}"


def _result(
    bench: Bench, expected: list[Prospect], tries: Mapping[int, list[tuple[float, Try]]], seed: int
) -> Rehearsal:
    limits = tuple(
        _limit(bench, effect, expected[i], tries[i]) for i, effect in enumerate(bench.effects)
    )
    return Rehearsal(Path(bench.twin.source).name, limits, seed, len(bench.plan.recordings))


def _limit(
    bench: Bench, effect: Effect, expected: Prospect, tries: list[tuple[float, Try]]
) -> Limit:
    times = expected.named
    status: Status = "predicted"
    if tries:
        times, last = tries[-1]
        status = "verified" if last.found else "not_found"
    if not isfinite(times):
        status = "never"
    misses = [t.said for _, t in tries if not t.found]
    rival = f"{expected.rival[0]} at {expected.rival[1]}" if expected.rival else "nothing"
    there = status in ("verified", "predicted")
    return Limit(
        *effect.label,
        effect.unit,
        effect.size(expected.named) if isfinite(expected.named) else None,
        effect.size(times) if there else None,
        share_of(effect, times, bench.around(effect.label[1])) if there else None,
        status,
        misses[-1] if misses else rival,
        times if there else None,
        effect.shrinks,
        tuple(t for _, t in tries),
    )


def _digest(twin: Twin, plan: Plan, seed: int) -> str:
    """Return what tells one rehearsal from another: the SHA-256 of twin, plan and seed."""
    own = [twin.mjcf_of(), asdict(plan), seed]
    return hashlib.sha256(json.dumps(own, sort_keys=True).encode()).hexdigest()[:16]
