"""What is uncertain while laws act that do not always.

No law has quite the form that it is given. What a stop lacks, as a dashpot, acts only where it is
hit: beside it a stationary force is too strong between its blows or too weak in them. Its force is
taken to be off by a share of itself, white from sample to sample, which leaves the outputs less
certain in a sample, and the state after it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.estimation.law_averages import LawAverages, both
from twin.estimation.system import Sampled, System, transition

Array = NDArray[np.float64]


def while_acting(
    averages: LawAverages, plant: Sampled, errors: Sequence[float], forces: Array | None = None
) -> LawAverages:
    """Return averages with what laws make uncertain while they act.

    Args:
        averages: without it, or with what it was for other shares.
        plant: the sampled system.
        errors: shares of their forces by which the laws are off, (l,); none where none is.
        forces: of the laws at the samples, (samples, l); those that they are known for without.
    """
    known, forces = averages.errors, averages.acting if forces is None else forces
    if not any((*errors, *known)) or tuple(errors) == known:
        return averages
    if forces is None or not np.all(np.isfinite(forces)):
        return averages
    more = np.square(errors) - (np.square(known) if known else 0.0)
    system, step_s = plant.system, plant.steps * plant.step_s
    moved = pushed(system, step_s)
    # a law may begin to act, or end, within the sample
    within = np.maximum(np.abs(forces[:-1]), np.abs(forces[1:])) ** 2 * more
    at = np.flatnonzero(np.any(within != 0.0, axis=1))
    kicks = dict(averages.kicks)
    for sample, kick in zip(
        (at + 1).tolist(), np.einsum("nl,kl,ml->knm", moved, within[at], moved), strict=True
    ):
        kicks[sample] = np.asarray(kick + kicks.get(sample, 0.0))
    blur = both(averages.blur, forces**2 * more @ (system.F**2).T)
    return replace(averages, blur=blur, kicks=kicks, acting=forces, errors=tuple(errors))


def pushed(system: System, step_s: float) -> Array:
    """Return what unit forces of the laws that are held over a sample do to the state, (n, l)."""
    return transition(system.A, system.E, step_s, 0)[1]
