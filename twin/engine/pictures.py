"""The missing force against the motion: what a person would look at first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.diagnosis.result import Finding, ForcePicture
from twin.engine.problem import Motion, Problem
from twin.engine.search import Explanation
from twin.mechanisms.mechanism import Law

Array = NDArray[np.float64]

MOST_POINTS, GRID, CYCLE_S = 6000, 201, 3.0
"""Points and grid of a picture, and how much of the motion its cycle shows [s]."""

PLACES = 6
"""Ports that are drawn besides those of findings."""


def force_pictures(
    best: Explanation, moved: Sequence[Motion], places: Sequence[str], findings: Sequence[Finding]
) -> tuple[ForcePicture, ...]:
    """Return the force that the twin's own equations lack at each port, against the motion there.

    It is what the estimated motion needs beyond the measured forces, with the masses, stiffnesses
    and dampings of the best explanation; low-passed at four times the highest natural frequency,
    above which there is only noise.
    """
    problem = best.hypothesis.problem
    needed = [_needed(best, t, motion) for t, motion in enumerate(moved)]
    out = []
    for place in list(dict.fromkeys(places))[: PLACES + len(findings)]:
        row = problem.model.port(place)
        pairs = [(m.q @ row, m.v @ row) for m in moved]
        drift = np.concatenate([d for d, _ in pairs])
        rate = np.concatenate([v for _, v in pairs])
        latent = np.concatenate([-(w @ row) / (row @ row) for w in needed])
        thin = max(1, len(drift) // MOST_POINTS)
        laws = [f for f in findings if isinstance(f.mechanism, Law) and f.location == place]
        edge = 1.02 * float(np.max(np.abs(drift)))
        grid = np.linspace(-edge, edge, GRID)
        law = std = cycle = None
        if laws:
            law, std = _law(laws[0], grid)
            cycle = _cycle(laws[0], problem, pairs)
        out.append(
            ForcePicture(place, drift[::thin], rate[::thin], latent[::thin], grid, law, std, cycle)
        )
    return tuple(out)


def _needed(best: Explanation, trial: int, motion: Motion) -> Array:
    """Return the forces on the coordinates that the motion needs besides the measured, (N, n)."""
    problem = best.hypothesis.problem
    model = problem.base(best.fit.z[: len(problem.base_unknowns)])
    force = motion.a @ model.M + motion.v @ model.R.T + motion.q @ model.K
    force -= problem.recordings[trial].u @ model.B.T
    inside = problem.frequencies[problem.frequencies < problem.sampling_hz / 2]
    corner = min(4 * float(np.max(inside, initial=1.0)), 0.4 * problem.sampling_hz)
    sos = signal.butter(4, corner, fs=problem.sampling_hz, output="sos")
    return np.asarray(signal.sosfiltfilt(sos, force, axis=0))


def _law(finding: Finding, grid: Array) -> tuple[Array, Array]:
    """Return the law's force over the grid, at next to no rate, and its deviation."""
    law = finding.mechanism
    assert isinstance(law, Law)
    speed = np.full_like(grid, 1e-3 if law.sticks else 0.0)

    def force(item: Law) -> Array:
        z = np.zeros_like(grid)
        middle = len(grid) // 2
        for k in range(middle, len(grid) - 1):
            z[k + 1] = item.remember(z[k], grid[k], grid[k + 1])
        for k in range(middle, 0, -1):
            z[k - 1] = item.remember(z[k], grid[k], grid[k - 1])
        return np.asarray(item.force(grid, speed, z, 1.0)) + 0 * grid

    centre, spread = force(law), np.zeros_like(grid)
    for name, std in finding.std.items():
        if np.isfinite(std) and std > 0:
            spread += (force(law.with_values({name: law.values[name] + std})) - centre) ** 2
    return centre, np.sqrt(spread)


def _cycle(finding: Finding, problem: Problem, pairs: Sequence[tuple[Array, Array]]) -> Array:
    """Return drift and force of the law along its liveliest few seconds."""
    law = finding.mechanism
    assert isinstance(law, Law)
    drift, rate = max(pairs, key=lambda pair: float(np.mean(pair[0] ** 2)))
    length = min(len(drift), round(CYCLE_S * problem.sampling_hz))
    first = int(np.argmax(np.convolve(drift**2, np.ones(length), mode="valid")))
    z = np.zeros(len(drift))
    if law.memory:
        for k in range(1, first + length):
            z[k] = law.remember(z[k - 1], drift[k - 1], drift[k])
    time: Array = np.asarray(np.arange(len(drift)) * problem.step_s, float)
    force = np.asarray(law.force(drift, rate, z, time)) + 0 * drift
    piece = slice(first, first + length)
    return np.column_stack([drift[piece], force[piece]])
