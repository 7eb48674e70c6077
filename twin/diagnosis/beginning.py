"""Where the fit of a grown hypothesis begins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.candidates import Candidate
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.known import RESOLVED
from twin.estimation.fit import ENOUGH, MOST_STEPS, Fit, fit
from twin.estimation.law_averages import LawAverages
from twin.estimation.likelihood import evaluate
from twin.estimation.model import Model
from twin.mechanisms.mechanism import Mechanism

Array = NDArray[np.float64]

WIDE = 2.0
"""Process noise that a fit begins with where it is far off, in prior deviations: 5 % of the inertia
forces, so that errors of as much do not end it."""

SHARP = 1e-5
"""Share of the rate at its port within which a jump that is simulated begins to change its sign: so
little that a part of a sample passes it. From there a fit widens it where it is wide; from a wide
one it takes a step for each factor of two or three."""


def added(hypothesis: Hypothesis, candidate: Candidate, start: Mechanism) -> Hypothesis:
    """Return the hypothesis with one more mechanism."""
    return replace(
        hypothesis,
        mechanisms=(*hypothesis.mechanisms, start),
        priors=(*hypothesis.priors, candidate.priors),
    )


def by_name(hypothesis: Hypothesis, z: Array) -> dict[str, float]:
    """Return values of a hypothesis' unknowns, (p,), by their names."""
    return {u.name: float(x) for u, x in zip(hypothesis.unknowns, z, strict=True)}


def carried(hypothesis: Hypothesis, known: Mapping[str, float]) -> Array:
    """Return values of all unknowns, (p,): known ones by name, the prior's mean for the rest.

    Another set of mechanisms may have other discrepancies, too, where they share a port.
    """
    return np.array([known.get(u.name, 0.0) for u in hypothesis.unknowns])


def moved_to(grown: Hypothesis, before: Hypothesis, z: Array, start: Mechanism) -> Array:
    """Return values of all unknowns: those of another hypothesis, and a first guess for the rest.

    Args:
        grown: the hypothesis whose unknowns they are.
        before: the one that ``z`` belongs to.
        z: its values, (p,).
        start: the mechanism that begins at its own values.
    """
    out = carried(grown, by_name(before, z))
    values = dict(start.values)
    for name, (whole, _, _) in start.shares.items():
        values[name] /= values[whole]
    titles = {f"{start.name} {start.place} {name}": value for name, value in values.items()}
    for i, unknown in enumerate(grown.unknowns):
        if unknown.name in titles:
            value = titles[unknown.name]
            if unknown.log:
                value = np.log(max(abs(value), 1e-300))
            out[i] = (value - unknown.mean) / unknown.deviation
    return out


def widened(hypothesis: Hypothesis, z: Array) -> Array:
    """Return values with so much process noise that a model far off still has a likelihood.

    Laws that act at times are as far off.
    """
    wide = [u.name.startswith("process noise") or u.role == "error" for u in hypothesis.unknowns]
    return np.where(wide, np.maximum(z, WIDE), z)


def as_sharp(hypothesis: Hypothesis, z: Array) -> Array:
    """Return values with laws that jump as sharp as they are seen: simulated, or as estimated."""
    share = SHARP if hypothesis.simulated else RESOLVED
    titles = {f"{law.name} {law.place} {law.resolved_by}": law.place for law in hypothesis.laws}
    out = z.copy()
    for i, unknown in enumerate(hypothesis.unknowns):
        if unknown.name in titles:
            rate = share * hypothesis.around(titles[unknown.name])[2]
            out[i] = (np.log(rate) - unknown.mean) / unknown.deviation
    return out


def nominal(hypothesis: Hypothesis, z: Array) -> Array:
    """Return values with masses, stiffnesses and dampings of the nominal twin."""
    out = z.copy()
    out[: len(hypothesis.problem.base_unknowns)] = 0.0
    return out


def from_nominal(hypothesis: Hypothesis, z: Array) -> Array:
    """Return values of the nominal twin with wide process noise."""
    return widened(hypothesis, nominal(hypothesis, z))


def beginnings(hypothesis: Hypothesis, z: Array) -> list[Array]:
    """Return where a fit may begin: as it is, with wide process noise, with the nominal twin.

    Where laws that jump are simulated, with wide noise and sharp jumps, too.
    """
    out = [z, widened(hypothesis, z), from_nominal(hypothesis, z)]
    sharp = as_sharp(hypothesis, out[1])
    return [*out, sharp] if hypothesis.simulated and not np.array_equal(sharp, out[1]) else out


def likeliest(
    model: Model, options: Sequence[Array], near: Sequence[LawAverages] | None = None
) -> tuple[float, Array]:
    """Return the values with the greatest log posterior: that, and the values.

    Args:
        model: whose values they are.
        options: values, (p,) each.
        near: averages of laws at values nearby, where they are known; those of each serve the next,
            for all are near to one another (``likelier``).
    """
    scored = []
    for z in options:
        value = -np.inf
        try:
            found = evaluate(model, z, derivatives=False, near=near)
        except np.linalg.LinAlgError:
            found = None
        if found is not None and np.isfinite(found.log_likelihood):
            value = found.log_likelihood - 0.5 * float(z @ z)
            near = found.averages
        scored.append((value, z))
    return max(scored, key=lambda pair: pair[0])


def likelier(model: Model, options: Sequence[Array]) -> tuple[float, Array]:
    """Return the same of values far apart: what laws do at one tells nothing of what they do there.

    Args:
        model: whose values they are.
        options: values, (p,) each.
    """
    return max((likeliest(model, [z]) for z in options), key=lambda pair: pair[0])


def attempted(
    model: Model, z: Array, steps: int = MOST_STEPS, hopeless: float = -np.inf,
    enough: float = ENOUGH, near: Sequence[LawAverages] | None = None,
) -> Fit | None:  # fmt: skip
    """Return a fit, None where the model has no likelihood to begin with."""
    try:
        return fit(model, z, steps, hopeless, enough=enough, near=near)
    except np.linalg.LinAlgError:
        return None


def start_of(hypothesis: Hypothesis) -> Array:
    """Return where a first fit begins: a process noise that is wide, so that nothing is far."""
    return widened(hypothesis, np.zeros(len(hypothesis.unknowns)))
