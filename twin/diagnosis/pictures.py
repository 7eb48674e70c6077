"""The missing force against the motion: what a person would look at first."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.explanation import Explanation
from twin.diagnosis.missing_force import along_motion, needed, smooth
from twin.diagnosis.motion import Motion
from twin.diagnosis.problem import Problem
from twin.diagnosis.result import Finding, ForcePicture
from twin.mechanisms.mechanism import Law

Array = NDArray[np.float64]

MOST_POINTS, GRID, CYCLE_S = 6000, 201, 3.0
"""Points and grid of a picture, and how much of the motion its cycle shows [s]."""

PLACES = 6
"""Ports that are drawn besides those of findings."""

STEP = 0.1
"""Standard deviations by which a parameter is moved for a law's slope in it."""


def force_pictures(
    best: Explanation, moved: Sequence[Motion], places: Sequence[str], findings: Sequence[Finding]
) -> tuple[ForcePicture, ...]:
    """Return the force that the twin's own equations lack at each port, against the motion there.

    It is what the estimated motion needs beyond the measured forces, with the masses, stiffnesses
    and dampings that were calibrated together with the laws, and beyond what the laws at the other
    ports give: points and law are relative to the same twin, and a port where nothing is missing
    shows nothing of its neighbour's. Low-passed at four times the highest natural frequency, above
    which there is only noise.
    """
    problem = best.hypothesis.problem
    laws = _laws(best)
    every_law = (*laws, *_known(problem, best.fit.z))
    along = {law: [along_motion(law, problem, m) for m in moved] for law in every_law}
    out = []
    for place in list(dict.fromkeys(places))[: PLACES + len(findings)]:
        port = problem.model.port_of(place)
        row = port.row
        mine = next((law for law in laws if law.place == place), None)
        elsewhere = [law for law in along if law is not mine]
        latent = []
        for t, motion in enumerate(moved):
            force = needed(problem, best.fit.z, t, motion)
            for law in elsewhere:
                force += along[law][t][:, None] * problem.model.port(law.place)
            latent.append(-(smooth(problem, force) @ row) / (row @ row))
        pairs = [(m.q @ row, m.v @ row) for m in moved]
        drift = np.concatenate([d for d, _ in pairs])
        rate = np.concatenate([v for _, v in pairs])
        every = max(1, len(drift) // MOST_POINTS)
        missing = np.concatenate(latent)[::every]
        bare = ForcePicture(
            place, drift[::every], rate[::every], missing, _grid(drift), unit=port.unit
        )
        named = _named(best, mine, pairs, latent, along[mine]) if mine is not None else {}
        out.append(replace(bare, **named))
    return tuple(out)


def _laws(best: Explanation) -> tuple[Law, ...]:
    """Return the laws that were found, with their estimates."""
    return tuple(m for m in best.hypothesis.at(best.fit.z) if isinstance(m, Law))


def _known(problem: Problem, z: Array) -> tuple[Law, ...]:
    """Return the laws that the model itself holds, with their estimates."""
    return tuple(m for m in problem.known_at(z) if isinstance(m, Law))


def _grid(values: Array) -> Array:
    edge = 1.02 * float(np.max(np.abs(values)))
    return np.linspace(-edge, edge, GRID)


def _named(
    best: Explanation,
    law: Law,
    pairs: Sequence[tuple[Array, Array]],
    latent: Sequence[Array],
    along: Sequence[Array],
) -> dict[str, Any]:
    """Return the law at a port as curve with its band, as a cycle, and over the liveliest time."""
    problem = best.hypothesis.problem
    livelier = [float(np.mean(d**2)) for d, _ in pairs]
    t = int(np.argmax(livelier))
    drift, rate = pairs[t]
    length = min(len(drift), round(CYCLE_S * problem.sampling_hz))
    first = int(np.argmax(np.convolve(drift**2, np.ones(length), mode="valid")))
    part = slice(first, first + length)
    time: Array = np.asarray(np.arange(len(drift)) * problem.step_s, float)

    def moving(item: Law) -> Array:
        end = first + length
        z = np.zeros(end)
        if item.memory:
            for k in range(1, end):
                z[k] = item.remember(z[k - 1], drift[k - 1], drift[k])
        force = item.force(drift[:end], rate[:end], z, time[:end])
        return np.asarray(force + 0 * z)[part]

    force = along[t][part]
    out = {
        "piece": np.column_stack([time[part], latent[t][part], force, _band(best, law, moving)]),
        "cycle": np.column_stack([drift[part], force]),
    }
    if law.memory:
        return out
    still, there = np.zeros(GRID), _grid(np.concatenate([d for d, _ in pairs]))
    quick = _grid(np.concatenate([v for _, v in pairs]))

    def of_drift(item: Law) -> Array:
        return np.asarray(item.force(there, still, still, 1.0) + still)

    def of_rate(item: Law) -> Array:
        return np.asarray(item.force(still, quick, still, 1.0) + still)

    d, v = drift[part], rate[part]
    alike = 1e-9 * float(np.max(np.abs(force), initial=1e-12))
    if np.allclose(law.force(d, 0 * v, 0 * v, time[part]) + 0 * d, force, rtol=0, atol=alike):
        return out | {"law": of_drift(law), "law_std": _band(best, law, of_drift)}
    if np.allclose(law.force(0 * d, v, 0 * v, time[part]) + 0 * d, force, rtol=0, atol=alike):
        return out | {"law_rate": quick, "law": of_rate(law), "law_std": _band(best, law, of_rate)}
    return out


def _band(best: Explanation, law: Law, force: Callable[[Law], Array]) -> Array:
    """Return the standard deviation of a law's force, from the full covariance, to first order."""
    hypothesis, fit = best.hypothesis, best.fit
    at = len(hypothesis.problem.base_unknowns)
    own: list[int] = []
    which = 0
    for number, mechanism in enumerate(hypothesis.mechanisms):
        if (mechanism.name, mechanism.place) == (law.name, law.place):
            own, which = list(range(at, at + len(mechanism.parameters))), number
        at += len(mechanism.parameters)
    C = fit.covariance[np.ix_(own, own)]
    slopes = []
    for i in own:
        step = np.zeros(len(fit.z))
        step[i] = STEP * np.sqrt(max(fit.covariance[i, i], 1e-24))
        up, down = (hypothesis.at(fit.z + s)[which] for s in (step, -step))
        assert isinstance(up, Law)
        assert isinstance(down, Law)
        slopes.append((force(up) - force(down)) / (2 * step[i]))
    G = np.column_stack(slopes)
    return np.sqrt(np.maximum(np.einsum("ki,ij,kj->k", G, C, G), 0.0))
