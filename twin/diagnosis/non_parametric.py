"""Where no law fits: a non-parametric restoring force in place of the laws that mimic one.

A search that only adds names builds a law that it does not know out of several that it does. The
non-parametric law is one mechanism with many parameters; where it is likelier than the names at its
place together, they are not what is there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from twin.diagnosis.beginning import added, moved_to
from twin.diagnosis.candidates import Candidate
from twin.diagnosis.discrepancy import DISCREPANCY_SHARE
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.left import left_share
from twin.diagnosis.missing_force import along_motion, needed, smooth
from twin.diagnosis.motion import Motion
from twin.estimation.fit import Fit
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Law, Mechanism
from twin.mechanisms.restoring_force import RestoringForce

Array = NDArray[np.float64]

MOST = 2
"""Ports at which the force is tried: those whose motion says most of it."""

LEFT = 0.1
"""Share of the missing force that the regression leaves, RMS: what the prior is weighed against."""


DRIFTS = 200
"""Displacements, visited as often as one another, along which a law is fitted to such a force."""


def doubtful(hypothesis: Hypothesis, fit: Fit, sizes: Sequence[float | None]) -> set[int]:
    """Return which mechanisms may stand for a law that has no name.

    Those are several at one port, a law that leaves more of the missing force at its port than laws
    are expected to, and a force that nobody measured.

    Args:
        hypothesis: the twin with its mechanisms.
        fit: how it came out.
        sizes: RMS modal force of each mechanism (``sizes.forces``).
    """
    mechanisms = hypothesis.at(fit.z)
    structural = [i for i, m in enumerate(mechanisms) if not isinstance(m, ChannelFault)]
    places = [mechanisms[i].place for i in structural]
    out = {i for i in structural if places.count(mechanisms[i].place) > 1}
    for index in structural:
        mechanism = mechanisms[index]
        share = left_share(hypothesis, fit, index, sizes)
        if isinstance(mechanism, Disturbance) or (share is not None and share > DISCREPANCY_SHARE):
            out.add(index)
    return out


def in_place_of(
    hypothesis: Hypothesis,
    fit: Fit,
    moved: Sequence[Motion],
    candidates: Sequence[Candidate],
    dubious: set[int],
) -> list[tuple[Hypothesis, list[Array]]]:
    """Return hypotheses with a non-parametric force instead of doubtful mechanisms.

    Each with values of its unknowns from which a fit may begin, the most promising first: at every
    port the law is fitted by least squares to the force that the motion needs. Where sensors say
    little of the motion, that may be no law to begin with; then it begins as nothing.
    """
    generic = [c for c in candidates if isinstance(c.starts[0], RestoringForce)]
    mechanisms = hypothesis.at(fit.z)
    if any(isinstance(mechanisms[i], RestoringForce) for i in dubious):
        return []
    at_ports = {m.place for m in mechanisms if not isinstance(m, ChannelFault)}
    wide = any(isinstance(mechanisms[i], Disturbance) for i in dubious)
    kept_laws = [m for i, m in enumerate(mechanisms) if i not in dubious and isinstance(m, Law)]
    known = [m for m in hypothesis.problem.known_at(fit.z) if isinstance(m, Law)]
    forces = missing_of(hypothesis, fit, moved, (*kept_laws, *known))
    options = []
    for candidate in generic:
        place = candidate.starts[0].place
        if not wide and place not in {mechanisms[i].place for i in dubious}:
            continue
        start, share = regressed(hypothesis, candidate, moved, forces)
        options.append((place in at_ports, share, candidate, start))
    options.sort(key=lambda option: option[:2], reverse=True)
    out = []
    for _, _, candidate, start in options[:MOST]:
        place = start.place
        there = {i for i, m in enumerate(mechanisms)
                 if m.place == place and not isinstance(m, ChannelFault)}  # fmt: skip
        out.append(exchanged(hypothesis, fit, there | dubious, candidate, start))
    return out


def named_for(
    hypothesis: Hypothesis, fit: Fit, moved: Sequence[Motion], candidates: Sequence[Candidate]
) -> list[tuple[Hypothesis, list[Array]]]:
    """Return hypotheses with a law that has a name in place of a non-parametric force.

    Each with values of its unknowns from which a fit may begin: from first guesses a law may have
    lost to one that is less like it.

    Args:
        hypothesis: with the force.
        fit: how it came out.
        moved: the motion of each recording.
        candidates: laws among them that are functions of the displacement may be the force.
    """
    mechanisms, out = hypothesis.at(fit.z), []
    forces = {m.place: i for i, m in enumerate(mechanisms) if isinstance(m, RestoringForce)}
    for candidate in candidates:
        place, laws = candidate.label[1], [s for s in candidate.starts if isinstance(s, Law)]
        if place in forces and laws and laws[0].elastic:
            force, row = mechanisms[forces[place]], hypothesis.problem.model.port(place)
            assert isinstance(force, RestoringForce)
            drift = np.quantile(np.concatenate([m.q @ row for m in moved]),
                                np.linspace(0.0, 1.0, DRIFTS))  # fmt: skip
            like = min((_like(law, force, drift) for law in laws), key=lambda pair: pair[0])[1]
            out.append(exchanged(hypothesis, fit, {forces[place]}, candidate, like))
    return out


def _like(law: Law, force: Law, drift: Array) -> tuple[float, Law]:
    """Return how far a law is from a force along displacements, (samples,), and where it is least.

    What is linear in the displacement is the structure's own.
    """
    still = np.zeros_like(drift)
    begun = np.array(list(law.values.values()))
    log = np.array([p.scale == "log" for p in law.parameters.values()])
    unit = np.where(log | (begun == 0.0), 1.0, np.abs(begun))

    def at(x: Array) -> Law:
        values = np.where(log, np.exp(np.clip(x, -300, 300)), unit * x)
        return law.with_values(dict(zip(law.parameters, values.tolist(), strict=True)))

    def left(x: Array) -> Array:
        beyond = at(x).force(drift, still, still, 0.0) - force.force(drift, still, still, 0.0)
        return np.asarray(beyond - drift * (drift @ beyond) / max(float(drift @ drift), 1e-300))

    first = np.where(log, np.log(np.maximum(np.abs(begun), 1e-300)), begun / unit)
    found = least_squares(left, first, x_scale="jac")
    return float(found.cost), at(found.x)


def missing_of(
    hypothesis: Hypothesis, fit: Fit, moved: Sequence[Motion], laws: Sequence[Law]
) -> list[Array]:
    """Return the force on the coordinates that no kept law gives, for each recording, (N, n)."""
    problem = hypothesis.problem
    out = []
    for t, motion in enumerate(moved):
        force = needed(problem, fit.z, t, motion)
        for law in laws:
            force += along_motion(law, problem, motion)[:, None] * problem.model.port(law.place)
        out.append(-smooth(problem, force))
    return out


def regressed(
    hypothesis: Hypothesis, candidate: Candidate, moved: Sequence[Motion], forces: Sequence[Array]
) -> tuple[Mechanism, float]:
    """Return a law fitted to the missing force, and the share of its power that it explains.

    The prior is a ridge.
    """
    start = candidate.starts[0]
    basis, target = terms_of(hypothesis, candidate, moved, forces)
    row = hypothesis.problem.model.port(start.place)
    weights, _ = ridge(basis, target)
    values = {name: d * w for (name, (_, d)), w in
              zip(candidate.priors.items(), weights.tolist(), strict=True)}  # fmt: skip
    everything = np.concatenate(forces)
    left = everything - np.outer(basis @ weights, row)
    share = 1 - float(np.sum(left**2) / np.sum(everything**2))
    return start.with_values(values), share


def terms_of(
    hypothesis: Hypothesis, candidate: Candidate, moved: Sequence[Motion], forces: Sequence[Array]
) -> tuple[Array, Array]:
    """Return the law's terms, each a prior deviation strong, (samples, terms), and the force."""
    start, problem = candidate.starts[0], hypothesis.problem
    assert isinstance(start, RestoringForce)
    columns = [
        np.concatenate([
            along_motion(start.with_values({name: start.scale}), problem, motion)
            for motion in moved
        ]) * candidate.priors[name][1] / start.scale
        for name in start.parameters
    ]  # fmt: skip
    row = problem.model.port(start.place)
    return np.column_stack(columns), np.concatenate([force @ row / (row @ row) for force in forces])


def ridge(basis: Array, target: Array) -> tuple[Array, Array]:
    """Return the estimates of weights that are about one, and their variances, (terms,) each."""
    noise = LEFT**2 * float(np.mean(target**2))
    covariance = noise * np.linalg.inv(basis.T @ basis + noise * np.eye(basis.shape[1]))
    return covariance @ (basis.T @ target) / noise, np.diag(covariance)


def exchanged(
    hypothesis: Hypothesis, fit: Fit, gone: set[int], candidate: Candidate, start: Mechanism
) -> tuple[Hypothesis, list[Array]]:
    """Return a hypothesis with a candidate in place of some mechanisms, and where fits begin."""
    kept = [i for i in range(len(hypothesis.mechanisms)) if i not in gone]
    fewer = replace(
        hypothesis,
        mechanisms=tuple(hypothesis.mechanisms[i] for i in kept),
        priors=tuple(hypothesis.priors[i] for i in kept),
    )
    grown = added(fewer, candidate, start)
    return grown, [moved_to(grown, hypothesis, fit.z, one) for one in (start, candidate.starts[0])]
