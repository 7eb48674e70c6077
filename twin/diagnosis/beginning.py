"""Where the fit of a grown hypothesis begins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.candidates import Candidate
from twin.diagnosis.hypothesis import Hypothesis
from twin.estimation.fit import ENOUGH, MOST_STEPS, Fit, fit
from twin.estimation.likelihood import evaluate
from twin.estimation.model import Model
from twin.mechanisms.mechanism import Mechanism

Array = NDArray[np.float64]

WIDE = 2.0
"""Process noise that a fit begins with where it is far off, in prior deviations: 5 % of the inertia
forces, so that errors of as much do not end it."""


def added(hypothesis: Hypothesis, candidate: Candidate, start: Mechanism) -> Hypothesis:
    """Return the hypothesis with one more mechanism."""
    return replace(
        hypothesis,
        mechanisms=(*hypothesis.mechanisms, start),
        priors=(*hypothesis.priors, candidate.priors),
    )


def moved_to(grown: Hypothesis, before: Hypothesis, z: Array, start: Mechanism) -> Array:
    """Return values of all unknowns: those of another hypothesis, and a first guess for the rest.

    Args:
        grown: the hypothesis whose unknowns they are.
        before: the one that ``z`` belongs to.
        z: its values, (p,).
        start: the mechanism that begins at its own values.
    """
    known = {u.name: float(x) for u, x in zip(before.unknowns, z, strict=True)}
    out = np.zeros(len(grown.unknowns))
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
        elif unknown.name in known:
            out[i] = known[unknown.name]
    return out


def widened(hypothesis: Hypothesis, z: Array) -> Array:
    """Return values with so much process noise that a model far off still has a likelihood."""
    wide = [u.name.startswith("process noise") for u in hypothesis.unknowns]
    return np.where(wide, np.maximum(z, WIDE), z)


def beginnings(hypothesis: Hypothesis, z: Array) -> list[Array]:
    """Return where a fit may begin: as it is, with wide process noise, with the nominal twin."""
    nominal = z.copy()
    nominal[: len(hypothesis.problem.base_unknowns)] = 0.0
    return [z, widened(hypothesis, z), widened(hypothesis, nominal)]


def likeliest(model: Model, options: Sequence[Array]) -> tuple[float, Array]:
    """Return the values with the greatest log posterior: that, and the values."""

    def posterior(z: Array) -> float:
        try:
            value = evaluate(model, z, derivatives=False).log_likelihood
        except (ValueError, np.linalg.LinAlgError):
            return -np.inf
        return value - 0.5 * float(z @ z) if np.isfinite(value) else -np.inf

    scored = [(posterior(z), z) for z in options]
    return max(scored, key=lambda pair: pair[0])


def attempted(
    model: Model, z: Array, steps: int = MOST_STEPS, hopeless: float = -np.inf,
    enough: float = ENOUGH,
) -> Fit | None:  # fmt: skip
    """Return a fit, None where the model has no likelihood to begin with."""
    try:
        return fit(model, z, steps, hopeless, enough=enough)
    except (ValueError, np.linalg.LinAlgError):
        return None


def start_of(hypothesis: Hypothesis) -> Array:
    """Return where a first fit begins: a process noise that is wide, so that nothing is far."""
    return widened(hypothesis, np.zeros(len(hypothesis.unknowns)))
