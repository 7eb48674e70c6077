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
from twin.diagnosis.result import Finding, ForcePicture
from twin.diagnosis.scales import ROUNDING
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
    and dampings that were calibrated together with the laws, and beyond what the laws at the other
    ports give: points and law are relative to the same twin, and a port where nothing is missing
    shows nothing of its neighbour's. Low-passed at four times the highest natural frequency, above
    which there is only noise.
    """
    problem = best.hypothesis.problem
    every = (*best.hypothesis.at(best.fit.z), *problem.known_at(best.fit.z))
    laws = [m for m in every if isinstance(m, Law)]
    found = laws[: len(best.hypothesis.laws)]
    along = {law: [along_motion(law, problem, m) for m in moved] for law in laws}
    out = []
    for place in list(dict.fromkeys(places))[: PLACES + len(findings)]:
        port = problem.model.port_of(place)
        row = port.row
        mine = next((law for law in found if law.place == place), None)
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
        some = slice(None, None, max(1, len(drift) // MOST_POINTS))
        missing = np.concatenate(latent)[some]
        bare = ForcePicture(place, drift[some], rate[some], missing, _grid(drift), unit=port.unit)
        named = _named(best, mine, moved, latent) if mine is not None else {}
        out.append(replace(bare, **named))
    return tuple(out)


def _grid(values: Array) -> Array:
    edge = 1.02 * float(np.max(np.abs(values)))
    return np.linspace(-edge, edge, GRID)


def _named(
    best: Explanation, law: Law, moved: Sequence[Motion], latent: Sequence[Array]
) -> dict[str, Any]:
    """Return the law at a port as curve with its band, as a cycle, and over the liveliest time."""
    problem = best.hypothesis.problem
    row = problem.model.port(law.place)
    drifts, rates = [m.q @ row for m in moved], [m.v @ row for m in moved]
    t = int(np.argmax([float(np.mean(d**2)) for d in drifts]))
    length = min(len(drifts[t]), round(CYCLE_S * problem.sampling_hz))
    first = int(np.argmax(np.convolve(drifts[t] ** 2, np.ones(length), mode="valid")))
    part = slice(first, first + length)
    d, v = drifts[t][part], rates[t][part]
    time: Array = np.asarray(np.arange(first, first + length) * problem.step_s, float)

    def moving(item: Law) -> Array:
        return along_motion(item, problem, moved[t])[part]

    force = moving(law)
    out = {
        "piece": np.column_stack([time, latent[t][part], force, _band(best, law, moving)]),
        "cycle": np.column_stack([d, force]),
    }
    if law.memory:
        return out
    still, there = np.zeros(GRID), _grid(np.concatenate(drifts))
    quick = _grid(np.concatenate(rates))

    def of_drift(item: Law) -> Array:
        return np.asarray(item.force(there, still, still, 1.0) + still)

    def of_rate(item: Law) -> Array:
        return np.asarray(item.force(still, quick, still, 1.0) + still)

    alike = ROUNDING * float(np.max(np.abs(force), initial=1e-12))
    if np.allclose(law.force(d, 0 * v, 0 * v, time) + 0 * d, force, rtol=0, atol=alike):
        return out | {"law": of_drift(law), "law_std": _band(best, law, of_drift)}
    if np.allclose(law.force(0 * d, v, 0 * v, time) + 0 * d, force, rtol=0, atol=alike):
        return out | {"law_rate": quick, "law": of_rate(law), "law_std": _band(best, law, of_rate)}
    return out


def _band(best: Explanation, law: Law, force: Callable[[Law], Array]) -> Array:
    """Return the standard deviation of a law's force, from the full covariance of its parameters.

    Slopes are those over one standard deviation to either side.
    """
    hypothesis, fit = best.hypothesis, best.fit
    names = [unknown.name for unknown in hypothesis.unknowns]
    own = [names.index(f"{law.name} {law.place} {name}") for name in law.parameters]
    steps = np.sqrt(np.maximum(np.diag(fit.covariance)[own], 1e-24))
    slopes = []
    for index, step in zip(own, steps, strict=True):
        near = [fit.z + sign * step * np.eye(len(names))[index] for sign in (1, -1)]
        up, down = (
            next(m for m in hypothesis.at(z) if (m.name, m.place) == (law.name, law.place))
            for z in near
        )
        assert isinstance(up, Law)
        assert isinstance(down, Law)
        slopes.append((force(up) - force(down)) / (2 * step))
    G, C = np.column_stack(slopes), fit.covariance[np.ix_(own, own)]
    return np.sqrt(np.maximum(np.einsum("ki,ij,kj->k", G, C, G), 0.0))
