"""Maximum a posteriori estimates by Gauss-Newton, and their evidence by Laplace's method."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from twin.estimation.likelihood import Model, Value, evaluate

Array = NDArray[np.float64]
Code = Literal["converged", "stopped", "ran away"]

ENOUGH = 0.01
"""Gain in log posterior [nat] below which a step is not worth another: evidences are compared to
tenths of a nat."""

TRIES = 8
"""Steps that may fail to climb, each damped ten times more, before a fit rests where it is."""


@dataclass(frozen=True)
class Fit:
    """A maximum a posteriori estimate.

    Attributes:
        model: what was fitted.
        z: the estimate in prior deviations from the prior's mean, (p,).
        covariance: of z, the inverse Hessian of the log posterior (Gauss-Newton), (p, p).
        log_likelihood: at the estimate.
        log_posterior: the same with the prior, up to a constant.
        log_evidence: log of the integral of likelihood times prior, by Laplace's method.
        code: how it ended.
        steps: evaluations with derivatives.
    """

    model: Model
    z: Array
    covariance: Array
    log_likelihood: float
    log_posterior: float
    log_evidence: float
    code: Code
    steps: int

    @property
    def values(self) -> dict[str, float]:
        """The unknowns by name, in SI units."""
        pairs = zip(self.model.unknowns, self.z, strict=True)
        return {unknown.name: unknown.value(float(z)) for unknown, z in pairs}

    @property
    def deviations(self) -> dict[str, float]:
        """Standard deviation of each unknown, to first order."""
        out = {}
        for i, (unknown, z) in enumerate(zip(self.model.unknowns, self.z, strict=True)):
            spread = unknown.deviation * float(np.sqrt(max(self.covariance[i, i], 0.0)))
            out[unknown.name] = spread * (abs(unknown.value(float(z))) if unknown.log else 1.0)
        return out


def fit(
    model: Model,
    start: Array | None = None,
    most: int = 25,
    hopeless: float = -np.inf,
    free: NDArray[np.bool_] | None = None,
    watch: Callable[[int, float], None] = lambda step, value: None,
) -> Fit:
    """Climb the log posterior by Gauss-Newton steps, damped where they do not climb.

    Args:
        model: with its unknowns and recordings.
        start: where to begin, in prior deviations, (p,); the prior's mean without.
        most: evaluations with derivatives at most.
        hopeless: log posterior that must be within reach; a fit that cannot get there by ten times
            what its next step promises stops.
        free: which unknowns may move, (p,); all without.
        watch: is told each step's number and log posterior.

    Raises:
        ValueError: the model has no likelihood where the fit begins.
    """
    p = len(model.unknowns)
    z = np.zeros(p) if start is None else np.asarray(start, float).copy()
    moving = np.ones(p, bool) if free is None else free
    here = evaluate(model, z)
    score = here.log_likelihood - 0.5 * float(z @ z)
    damping, step = 0.0, 0
    code: Code = "stopped"
    for step in range(1, most + 1):
        watch(step, score)
        H = here.information + np.eye(p)
        g = np.where(moving, here.gradient - z, 0.0)
        Hm = np.where(np.outer(moving, moving), H, np.eye(p))
        moved = None
        for _ in range(TRIES):
            damped = Hm + damping * np.diag(np.diag(Hm))
            delta = np.linalg.solve(damped, g)
            promise = float(g @ delta - 0.5 * delta @ Hm @ delta)
            if promise < ENOUGH:
                break
            found = _try(model, z + delta)
            if found is not None:
                value = found.log_likelihood - 0.5 * float((z + delta) @ (z + delta))
                if value > score:
                    moved = found, value, z + delta
                    damping = damping / 10 if damping > 1e-6 else 0.0
                    break
            damping = max(10 * damping, 1e-3)
        if promise < ENOUGH:
            code = "converged"
            break
        if moved is None:
            break
        gained = moved[1] - score
        here, score, z = moved
        if gained < ENOUGH and damping == 0.0:
            code = "converged"
            break
        if score + 10 * max(gained, promise) < hopeless:
            break
    H = here.information + np.eye(p)
    H = np.where(np.outer(moving, moving), H, np.eye(p))
    sign, log_det = np.linalg.slogdet(H)
    return Fit(
        model, z, np.asarray(np.linalg.inv(H)), here.log_likelihood, score,
        score - 0.5 * float(log_det), code if sign > 0 else "ran away", step,
    )  # fmt: skip


def _try(model: Model, z: Array) -> Value | None:
    try:
        # a step may lead anywhere; where nothing is finite it is not taken
        with np.errstate(all="ignore"):
            found = evaluate(model, z)
    except (ValueError, np.linalg.LinAlgError):
        return None
    return found if np.isfinite(found.log_likelihood) else None
