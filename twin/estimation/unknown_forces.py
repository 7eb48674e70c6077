"""How uncertain the forces of laws are because the state that they depend on is estimated."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from twin.estimation.kalman import EquivalentLinear, gains, start_covariances
from twin.estimation.model import Assembly
from twin.estimation.passing import Run
from twin.estimation.system import Noise

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

WIDEST, POINTS, NEAR = 3.0, 12, 0.1
"""Deviations to which a force is averaged over an uncertain state, and in how many parts: all but
0.3 % of the probability, half a deviation each; and what a rate changes by, in its deviations,
below which the mean force's chord is its tangent."""


def unknown_forces(
    here: Assembly, passed: Run, noise: Noise, equivalent: EquivalentLinear, tangent: Array
) -> Array:
    """Return how uncertain laws' forces are because the state is, (samples, l).

    Standard deviations over the predictor's own covariance, less what linear forces have of it:
    that is in the gains.

    Args:
        here: the laws.
        passed: a pass over the recording.
        noise: its levels.
        equivalent: what they add to the linear system.
        tangent: the same as forces of the state, (l, n).
    """
    out = np.zeros_like(passed.f)
    plant, step_s = passed.sampled, here.trials[0].step_s
    try:
        gain = gains(plant, noise, equivalent=equivalent)
    except np.linalg.LinAlgError:
        return out
    begun = start_covariances(plant, noise, gain, equivalent)[: len(out)]

    def deviation(row: Array) -> Array:
        known = np.full(len(out), max(float(row @ gain.predicted @ row), 0.0))
        known[: len(begun)] = np.maximum(np.einsum("i,kij,j->k", row, begun, row), 0.0)
        return np.asarray(np.sqrt(known))

    for j, law in enumerate(here.laws):
        rows, entry = (plant.system.drift[j], plant.system.rate[j]), plant.system.E[:, j]
        motion = np.stack([passed.x @ row for row in rows])
        wide = np.stack([deviation(row) for row in rows])
        linear = deviation(tangent[j])
        z, time = passed.z[:, j].sum(axis=1), np.arange(len(out)) * step_s

        def force(at: Indices, d: Array, v: Array, law=law, j=j, z=z, time=time) -> Array:  # type: ignore[no-untyped-def]
            found = law.force(d, v, z[at], time[at], *here.numbers[j, : law.count])
            return np.asarray(np.broadcast_to(found, d.shape), float)

        every = np.arange(len(out))
        least, most = (force(every, *(motion + s * wide)) for s in (-WIDEST, WIDEST))
        # elsewhere it cannot vary by more than what is linear
        varied = np.flatnonzero(np.abs(most - least) > 2 * linear)
        moved = np.diff(motion[1], prepend=motion[1, 0])[varied]
        braking = step_s * float(rows[1] @ entry), step_s * float(tangent[j] @ entry)
        variance = _variance(
            partial(force, varied), motion[:, varied], wide[:, varied], moved, braking
        )
        out[varied, j] = np.sqrt(np.maximum(variance - linear[varied] ** 2, 0.0))
    return out


def _variance(
    force: Callable[[Array, Array], Array], motion: Array, wide: Array, moved: Array,
    braking: tuple[float, float],
) -> Array:  # fmt: skip
    """Return the variance of a force over an uncertain displacement and rate, (samples,).

    A law that brakes leaves less of an uncertain rate, over a sample exp(h e df/dv) with the mean
    slope between the rates of two samples: where it holds, nothing.

    Args:
        force: of displacement and rate, (., samples).
        motion: displacement and rate, (2, samples).
        wide: their standard deviations, (2, samples).
        moved: how far the rate came in a sample, (samples,).
        braking: h e, and h e df/dv as the covariance has it.
    """
    (d, v), (wide_d, wide_v) = motion, wide
    xi = (WIDEST * (2 * np.arange(POINTS) + 1 - POINTS) / POINTS)[:, None]
    share = np.exp(-0.5 * xi[:, 0] ** 2)
    share /= np.sum(share)
    after, before = (force(d + 0 * xi, at + xi * wide_v) for at in (v, v - moved))
    slope = share @ (after * xi) / np.maximum(wide_v, 1e-300)  # none is needed of what is known
    far = np.abs(moved) > NEAR * wide_v
    slope[far] = (share @ (after - before))[far] / moved[far]
    left = np.exp(np.minimum(braking[0] * slope - braking[1], 0.0))
    there = force(d + xi * wide_d, v + xi * wide_v * left)
    return np.asarray(share @ there**2 - (share @ there) ** 2)
