"""The plants of a hypothesis: one for each set of masses, ranges and inputs' bands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.discrepancy import Discrepancy
from twin.diagnosis.plant import plant_of
from twin.diagnosis.plant_states import Plant, band_limited
from twin.diagnosis.problem import Problem
from twin.mechanisms.mechanism import Mechanism

Array = NDArray[np.float64]

START_WIDTH = 3.0
"""Deviation of the state before the first sample, in RMS values of the nominal motion."""

SLOWEST_HZ = 0.1
"""Frequency that a rigid mode counts as when its rate before the first sample is bounded."""

AMPLIFIED = 10.0
"""By which the motion of an added coordinate may exceed its static one before the first sample:
that of a resonance of 5 % damping."""

TINY = 1e-12
"""Displacement that a motion has at least [m], so that covariances are not singular."""


@dataclass(frozen=True)
class Plants:
    """The distinct plants of a hypothesis.

    Attributes:
        stepped: as the predictor steps them.
        own: the same with the damping that modes above half the sampling rate have, in which the
            laws are simulated; none where nothing is, or there are no such modes.
        which: index of each recording's.
    """

    stepped: tuple[Plant, ...]
    own: tuple[Plant, ...]
    which: tuple[int, ...]


def in_each(
    mechanisms: Sequence[Mechanism], ranged: Sequence[Mechanism], logs: Array, count: int
) -> list[tuple[Mechanism, ...]]:
    """Return the mechanisms as they are in each of so many recordings.

    Args:
        mechanisms: as they are on the average.
        ranged: those that differ, by name and place.
        logs: ends in the logarithm of their strength in each recording, over that.
        count: of the recordings.
    """
    where = {(m.name, m.place): i for i, m in enumerate(ranged)}
    times = np.exp(np.reshape(logs[len(logs) - count * len(where) :], (-1, count)))

    def there(mechanism: Mechanism, t: int) -> Mechanism:
        at = where.get((mechanism.name, mechanism.place))
        return mechanism if at is None else mechanism.scaled(float(times[at, t]))

    return [tuple(there(m, t) for m in mechanisms) for t in range(count)]


def plants_at(
    problem: Problem, z: Array, mechanisms: Sequence[tuple[Mechanism, ...]],
    latent: Sequence[Discrepancy], simulated: bool,
) -> Plants:  # fmt: skip
    """Return the plants at values z of the base unknowns, (base unknowns,).

    Args:
        problem: whose recordings they are.
        z: the values.
        mechanisms: of each recording, in any order; the structure's are alike in all.
        latent: each discrepancy.
        simulated: whether the laws are.

    Raises:
        NoLikelihoodError: mechanisms that take more damping than there is.
    """
    base = problem.base(z)
    stepped: list[float | None] = [problem.step_s if problem.calmed else None]
    if simulated and problem.rings:
        stepped.append(None)
    cases = list(zip([r.load for r in problem.recordings], mechanisms, strict=True))
    distinct = list(dict.fromkeys(cases))
    banded = [(distinct.index(c), r.bands) for c, r in zip(cases, problem.recordings, strict=True)]
    variants = list(dict.fromkeys(banded))
    made: list[tuple[Plant, ...]] = []
    for step_s in stepped:
        plants = []
        for load, there in distinct:
            model = base
            for place, mass in load:
                model = model.loaded(place, mass)
            plants.append(plant_of(model, there, latent, problem.readings, problem.noise_gain,
                                   problem.pseudo_forces, step_s, problem.step_s))  # fmt: skip
        made.append(tuple(band_limited(plants[index], bands) for index, bands in variants))
    own = made[1] if len(made) > 1 else ()
    return Plants(made[0], own, tuple(variants.index(b) for b in banded))


def start_covariance(problem: Problem, trial: int, plant: Plant) -> Array:
    """Return the covariance of the state before the first sample of a recording, (n, n)."""
    own, total = len(problem.scale[trial]), plant.system.coordinates
    w = np.maximum(np.sqrt(np.abs(np.diag(problem.model.K))), 2 * np.pi * SLOWEST_HZ)
    q = START_WIDTH * problem.scale[trial] + TINY
    variance = np.zeros(2 * total)
    variance[:own], variance[total : total + own] = q**2, (q * w) ** 2
    if total > own:
        # what hangs on the structure or gives way under it is driven by the structure's motion
        w_own = np.sqrt(plant.stiffness[own:] / plant.mass[own:])
        more = AMPLIFIED * np.max(q * w**2, initial=TINY) / w_own**2
        variance[own:total], variance[total + own :] = more**2, (more * w_own) ** 2
    out = np.zeros((2 * total + len(plant.start),) * 2)
    out[range(2 * total), range(2 * total)] = variance
    out[2 * total :, 2 * total :] = plant.start
    return out
