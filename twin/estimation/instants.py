"""How uncertain a simulation leaves the instants at which its laws' forces jump.

The rate at a law's port is known as well as the deviations from a simulation are: with a standard
deviation s. A force that jumps where the rate passes zero jumps earlier or later by s over the
acceleration there, and an analyser's filter shows a jump in the samples around it, so that these
are more uncertain than their noise. By how much two neighbours of the simulation tell (sigma
points, Julier and Uhlmann 1997), whose rates at the port are off by +s and -s: beside them the law
is solved over every part of a sample, and takes back of a deviation what it holds, as friction
does that sticks. What is taken back returns by the acceleration's deviation.
"""

# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

from collections.abc import Mapping

import numba
import numpy as np
from numpy.typing import NDArray

from twin.errors import NoLikelihoodError
from twin.estimation.blows import responses
from twin.estimation.implicit import rate_share, solve_force
from twin.estimation.kalman import matrices_of
from twin.estimation.law_averages import LawAverages
from twin.estimation.laws import addresses
from twin.estimation.model import Assembly
from twin.estimation.passing import Simulation
from twin.estimation.sensitivities import numbers_of, simulation_matrix
from twin.estimation.simulated import filtered
from twin.estimation.system import Noise, Sampled

Array = NDArray[np.float64]

RESOLVED = 0.75
"""Share of the rate at the end of a part in what a law sees of it, below which parts of a sample
resolve how it changes with the rate, and it does not jump: x of ``twin.estimation.implicit`` is 2
there, where what friction should hold would change the sign of its rate from part to part."""

NEGLIGIBLE = 1e-3
"""Share of a variance that changes nothing beside it."""


def unknown_instants(
    here: Assembly, plant: Sampled, noise: Noise, averages: LawAverages, beside: Simulation
) -> Array:
    """Return the variances that this adds to the outputs, (samples, m).

    Laws with a memory, and those that do not jump with the rate, add nothing.

    Args:
        here: for the laws.
        plant: its sampled system.
        noise: its levels.
        averages: what the laws do to small deviations from the simulation.
        beside: the simulation.

    Raises:
        NoLikelihoodError: deviations that grow without bound.
    """
    assert plant.driven is not None
    system, own, count = plant.system, plant.driven.simulated.system, len(here.laws)
    samples, filtering = len(beside.e), averages.filtering(plant)
    strayed = _strayed(filtering.whole, matrices_of(filtering, noise)[4], samples)
    sizes, returning = (
        np.sqrt(_variances(rows, strayed, filtering.whole, averages.kicks, samples))
        for rows in (system.rate, system.rate @ filtering.system.A)
    )
    if not np.all(np.isfinite(sizes + returning)):
        raise NoLikelihoodError("deviations from the simulation grow without bound")
    push = np.vstack([own.drift, own.rate]) @ simulation_matrix(plant)[:, -count:]
    off = np.zeros((len(beside.forces), 2 * count))
    _neighbours(
        addresses(here.laws), numbers_of(here), push, np.ascontiguousarray(here.scales),
        plant.step_s, plant.steps, beside.forces, beside.moved, sizes, returning * plant.step_s,
        off,
    )  # fmt: skip
    none = np.empty((*off.shape, 0))
    seen, _ = filtered(off, none, plant.driven.weights[:1], plant.steps, samples)
    variance = np.mean(seen.reshape(samples, 2, count) ** 2, axis=1)
    return np.asarray(variance @ (system.F**2).T)


def blown(here: Assembly, index: int, plant: Sampled) -> tuple[dict[int, Array], Array | None]:
    """Return how much less certain blows leave the state, and the outputs about their onsets.

    What a filter shows of a blow does not tell within a part of a sample when it begins. What held
    until then jumps by its force at an instant with a deviation of a part over sqrt(3), as one has
    that is anywhere within a part to either side.

    Args:
        here: for the laws.
        index: of the recording.
        plant: its sampled system.

    Returns:
        By sample, what is added to the state's covariance before it, (n, n); and variances of the
        outputs, (samples, m), None without blows.
    """
    trial, low_pass = here.trials[index], here.low_pass
    if trial.blows is None or low_pass is None:
        return {}, None
    system, steps, samples = plant.system, plant.steps, len(trial.y)
    laws, numbers, kicks = addresses(here.laws), numbers_of(here), dict[int, Array]()
    push = system.rate @ simulation_matrix(plant)[:, -len(here.laws) :]
    seen, onsets = np.zeros((samples, len(system.F))), trial.blows.onsets(steps)
    parts = np.asarray(np.rint(np.array(onsets) * steps), int)
    response = responses(samples, parts, low_pass, steps)
    when = plant.step_s / np.sqrt(3)
    for j, law in enumerate(here.laws):
        if not _jumps(laws[j], numbers[j], push[j, j], here.scales[j, 2]):
            continue
        _, d, v = here.scales[j, :3]
        impulse = when * abs(float(law.force(d, v, 0.0, 0.0, *here.numbers[j, : law.count])))
        moved = system.E[:, j] * impulse
        for onset in onsets:
            sample = int(onset) + 1
            kicks[sample] = np.asarray(np.outer(moved, moved) + kicks.get(sample, 0.0))
        shown = steps * impulse / trial.step_s * response
        seen += np.outer(np.sum(shown**2, axis=1), system.F[:, j] ** 2)
    return kicks, seen


def _variances(
    rows: Array, strayed: Array, A: Array, kicks: Mapping[int, Array], samples: int
) -> Array:
    """Return variances of deviations along rows, (samples, l): as strayed, and of kicks before.

    Args:
        rows: of the state, (l, n).
        strayed: covariance of the state everywhere, (n, n).
        A: what a sample does to it, (n, n).
        kicks: by sample, what is added to it there.
        samples: how many.
    """
    out = np.tile(np.einsum("ln,nk,lk->l", rows, strayed, rows), (samples, 1))
    for first, more in kicks.items():
        P = more
        for k in range(max(first - 1, 0), samples):  # its sample is uncertain as a whole
            gone = np.einsum("ln,nk,lk->l", rows, P, rows)
            if not np.any(gone > NEGLIGIBLE * out[k]):
                break
            out[k] += gone
            P = A @ P @ A.T
    return np.maximum(out, 0.0)


def _strayed(A: Array, Q: Array, samples: int) -> Array:
    """Return the covariance of deviations from a simulation after so many samples at least, (n, n).

    The sum of A^k Q A^kT, by doubling.
    """
    found, taken = Q, 1
    with np.errstate(all="ignore"):  # what runs away is not finite
        while taken < samples:
            found, A, taken = found + A @ found @ A.T, A @ A, 2 * taken
    return np.asarray(found)


@numba.njit(nogil=True, cache=True)
def _jumps(law, numbers, ev, scale):
    """Return whether a law jumps with the rate, a newton of which changes that by ev in a part."""
    address = numbers.ctypes.data
    return law[2] == 0 and rate_share(law, address, 0.0, 0.0, ev, 0.0, scale) >= RESOLVED


@numba.njit(nogil=True, cache=True)
def _neighbours(
    laws, numbers, push, scales, part_s, steps, forces, moved, sizes, returning, out
):  # fmt: skip
    """Fill what the forces of neighbours of a simulation have beyond its own.

    Args:
        laws: addresses of forces and flows, and parts of memory, (l, 3).
        numbers: of the laws, (l, most).
        push: what the forces add to displacements and rates at the ports, (2 l, l).
        scales: of force, displacement and rate at each port, and how far it yields, (l, 4).
        part_s: length of a part [s].
        steps: parts of a sample.
        forces: of the simulation, (parts, l).
        moved: displacements, then rates, at the ports in it, (parts + 1, 2 l).
        sizes: of the rates' deviations, (samples, l).
        returning: how much of what was taken back of them returns after a part, (samples, l).
        out: filled, (parts, 2 l): those with rates above, then those with rates below.
    """
    count, still = len(laws), np.zeros(1)
    for j in range(count):
        at, ed, ev = numbers[j].ctypes.data, push[j, j], push[count + j, j]
        if not _jumps(laws[j], numbers[j], ev, scales[j, 2]):
            continue
        for a, side in enumerate((1.0, -1.0)):
            left, slope, more = sizes[0, j], 1.0, 0.0
            for k in range(len(forces)):
                sample = min(k // steps, len(sizes) - 1)
                size = sizes[sample, j]
                f, there = forces[k, j], min(left + returning[sample, j], size)
                begin, end = moved[k, count + j], moved[k + 1, count + j]
                if begin * end > 0 and min(abs(begin), abs(end)) > there:  # it keeps its sign
                    left, more = there, 0.0
                    continue
                back, off = there - left, side * there
                d = moved[k + 1, j] - ed * f + off * part_s
                force, slope = solve_force(
                    laws[j], at, moved[k, j], begin + off, d, end - ev * f + off, still, ed, ev,
                    f + more, slope, (k + 0.5) * part_s, scales[j], part_s,
                )  # fmt: skip
                more = force - f
                left = min(abs(off + ev * more), size)
                # what has just returned and is held again moves nothing
                held = min(max(back - left, 0.0) / abs(ev), abs(more))
                out[k, a * count + j] = more - held * np.sign(more)
