"""What is concealed in a case, by its table's rule: effects that show and stay physical."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from twin.errors import TwinError

from . import absorbed, near, outside, pairs
from .chain import Chain
from .concealed import Concealed
from .distinct import evidence
from .mechanisms import Mechanism, build
from .plans import Test, log_uniform
from .rehearsal import Rehearsal
from .rig import Rig
from .strengths import draw
from .tables import Combination

VISIBLE = 3.0
"""The effect changes the outputs of some training recording by at least this many times noise."""

CLEAR_NATS = 25.0
"""A soft base is by so much likelier than the best frame on a hard one."""

TRIES = 60


def conceal(
    rng: np.random.Generator, table: str, combination: Combination, rig: Rig,
    tests: tuple[Test, ...], chain: Chain, recorded: tuple[int, ...], name: str,
) -> Concealed:  # fmt: skip
    """Draw the effects of a case.

    Args:
        rng: draws.
        table: by whose rule.
        combination: mechanisms and places.
        rig: as built.
        tests: the training recordings.
        chain: how they are measured.
        recorded: floors whose accelerometers are recorded, from 1.
        name: of the case, for the message.

    Raises:
        TwinError: no strength would do.
    """
    if not combination:
        return Concealed()
    rehearsal = Rehearsal.of(rig, tests, chain, recorded)
    rules = {
        "absorbed": absorbed.draw_one, "outside": outside.draw_one, "near": near.draw_one,
        "pairs": pairs.draw_two,
    }  # fmt: skip
    found = rules.get(table, draw_one)(rng, combination, rehearsal)
    if found is None:
        what = " and ".join(f"{m} at {place}" for m, place in combination)
        raise TwinError(f"{name}: no strength of {what} can be seen and is physical")
    return found


def draw_one(
    rng: np.random.Generator, combination: Combination, rehearsal: Rehearsal
) -> Concealed | None:
    """Draw one effect that changes the recordings by some times their noise."""
    (name, place), noise = combination[0], rehearsal.chain.noise
    for _ in range(TRIES):
        mechanism = draw(rng, name, place, rehearsal.rig, rehearsal.scale)
        if name == "unmeasured_force":
            mechanism = _scaled(rng, mechanism, rehearsal)
        runs = rehearsal.moved([mechanism])
        effect = rehearsal.effect([mechanism], runs)
        if name == "base_compliance" and not _clear(mechanism, rehearsal):
            continue
        if rehearsal.physical(runs) and effect > VISIBLE * noise:
            return Concealed((mechanism,), effect)
    return None


def _clear(mechanism: Mechanism, rehearsal: Rehearsal) -> bool:
    rig, chain = rehearsal.rig, rehearsal.chain
    system = build(rig, mechanism)
    tests, recorded = rehearsal.tests, rehearsal.recorded
    return evidence(rig, system, tests, chain.fine, chain.noise, recorded) >= CLEAR_NATS


def _scaled(rng: np.random.Generator, mechanism: Mechanism, rehearsal: Rehearsal) -> Mechanism:
    """Return an unmeasured force of a drawn effect in the middle recording."""
    changes = rehearsal.changes([mechanism], rehearsal.moved([mechanism]))
    unit = np.exp(np.mean(np.log(changes)))
    wanted = log_uniform(rng, VISIBLE * rehearsal.chain.noise, 0.5)
    parameters = {**dict(mechanism.parameters), "rms": float(wanted / unit)}
    return replace(mechanism, parameters=tuple(parameters.items()))
