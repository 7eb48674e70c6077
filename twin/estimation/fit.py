"""Maximum a posteriori estimates by Gauss-Newton, and their evidence by Laplace's method.

What laws do on the average of the motion (``LawAverages``) is held while a step is looked for, for
the derivatives know nothing of its change, and follows after each: iteratively reweighted least
squares (Holland and Welsch 1977). A step may lose by what follows; the best place is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from twin.errors import NoLikelihoodError
from twin.estimation.law_averages import LawAverages
from twin.estimation.likelihood import Value, evaluate
from twin.estimation.model import Model

Array = NDArray[np.float64]
Likelihood = Callable[..., Value]
"""value(z, derivatives, averages, near): the log likelihood at values z, as ``evaluate`` has it."""

Code = Literal["converged", "stopped", "ran away"]
"""How a fit ended: no step promises anything more; its steps were used up, or none climbed; or
it was still climbing ``FARTHEST`` deviations away from the prior."""

ENOUGH = 0.01
"""Gain in log posterior [nat] below which a step is not worth another: evidences are compared to
tenths of a nat."""

LONGEST = 3.0
"""Farthest step of a positive unknown's logarithm (a factor of twenty), and of others in prior
deviations: what lies beyond, the slopes here know nothing of."""

FASTEST = 1.0
"""Most that the logarithm of a level falls by in a step: Gauss and Newton promise a change of -0.43
for it, and no less than -1/2 for none at all, but for levels that do the same together any."""

FARTHEST = 8.0
"""Prior deviations beyond which a fit that has not converged ran away: by chance, one in 10^15."""

AFRESH = 4, 8, 16
"""Steps after which averages are looked for as if from nowhere, rarer as they change less: a
state that laws were simulated from where much was wrong leads astray where it is not."""

CALMER = (1.0, 2.0)
"""By how much the logarithm of latent forces' levels is tried lower beside averages found
afresh: to 0.37 and 0.14 of them."""

PATIENCE, WORTH = 3, 0.5
"""Steps in a row that may together gain less than so much [nat], or lose it by the averages that
follow them: what Laplace's method itself is off by."""

MOST_STEPS = 25
"""Evaluations with derivatives of a fit at most, unless another number is asked for."""

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
        averages: what the laws do on the average of each recording.
    """

    model: Model
    z: Array
    covariance: Array
    log_likelihood: float
    log_posterior: float
    log_evidence: float
    code: Code
    averages: tuple[LawAverages, ...] = ()

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
    most: int = MOST_STEPS,
    hopeless: float = -np.inf,
    free: NDArray[np.bool_] | None = None,
    likelihood: Likelihood | None = None,
    enough: float = ENOUGH,
    near: Sequence[LawAverages] | None = None,
    patience: float = WORTH,
    curved: bool = True,
) -> Fit:
    """Climb the log posterior by Gauss-Newton steps, damped where they do not climb.

    Args:
        model: with its unknowns and recordings.
        start: where to begin, in prior deviations, (p,); the prior's mean without.
        most: evaluations with derivatives at most.
        hopeless: log evidence that must be within reach; a fit that cannot get there by ten times
            what its next step promises stops.
        free: which unknowns may move, (p,); all without.
        likelihood: another one of the same unknowns than that of the innovations.
        enough: gain in log posterior [nat] below which a step is not worth another.
        near: averages of laws at values nearby, where they are known.
        patience: gain [nat] below which ``PATIENCE`` steps are not worth another.
        curved: whether to see how curved it is at the end; no covariance, no evidence without.

    Raises:
        NoLikelihoodError: the model has no likelihood where the fit begins.
    """
    p = len(model.unknowns)
    z = np.zeros(p) if start is None else np.asarray(start, float).copy()
    moving = np.ones(p, bool) if free is None else free
    at = partial(evaluate, model, free=free) if likelihood is None else likelihood
    with np.errstate(all="ignore"):
        here = at(z, True, None, near)
    if not np.all(np.isfinite(here.information)):
        raise NoLikelihoodError("the model runs away where the fit begins")
    score = here.log_likelihood - 0.5 * float(z @ z)
    damping = 0.0
    # values that were measured, each of which is off by a nat there
    measured = sum(trial.y.size for trial in here.trials) or np.inf
    gains: tuple[float, ...] = ()
    again = not any(run.averages.start is not None for run in here.runs)
    # a short fit is over before what it began with leads far astray
    stray = not again and most >= MOST_STEPS and _simulated(here)
    best = here, score, z
    code: Code = "stopped"
    for number in range(most):
        moved, damping, promise = _climbed(model, at, z, here, score, moving, damping)
        settled = promise < enough
        if not settled:
            last = not curved and number + 1 == most
            found = None if moved is None else _found(at, moved, here.averages, slopes=not last)
            if moved is None or found is None:
                break
            z = moved
            if stray and number + 1 in AFRESH:
                z, found = _afresh(model, at, z, found, moving)
            gained = found.log_likelihood - 0.5 * float(z @ z) - score
            here, score = found, score + gained
            gains = (*gains[1 - PATIENCE :], max(score - best[1], 0.0))
            best = (here, score, z) if score > best[1] else best
            lost = promise > measured  # nothing near is likely, and the averages follow from afar
            tired = len(gains) == PATIENCE and sum(gains) < max(patience, enough) and not lost
            settled = tired or (abs(gained) < enough and damping == 0.0)
        if settled:
            code = "converged"
            if again:
                break
            before, again = best[0], not stray
            z, here = _afresh(model, at, best[2], before, moving)
            if here is before:
                break
            score, gains, code = here.log_likelihood - 0.5 * float(z @ z), (), "stopped"
            best = here, score, z
            continue
        if _evidence(best[1], _hessian(best[0], moving)) + 10 * max(gained, promise) < hopeless:
            break
    here, score, z = best
    H = _hessian(here, moving)
    if code == "stopped" and np.max(np.abs(z[moving]), initial=0.0) > FARTHEST:
        code = "ran away"
    return Fit(
        model, z, np.asarray(np.linalg.inv(H)), here.log_likelihood, score, _evidence(score, H),
        code, here.averages,
    )  # fmt: skip


def _climbed(
    model: Model, at: Likelihood, z: Array, here: Value, score: float, moving: NDArray[np.bool_],
    damping: float,
) -> tuple[Array | None, float, float]:  # fmt: skip
    """Return where a step climbs to, (p,), if one does, the next damping, and what was promised."""
    H = _hessian(here, moving)
    g = np.where(moving, here.gradient - z, 0.0)
    promise = 0.0
    for _ in range(TRIES):
        delta = np.asarray(np.linalg.solve(H + damping * np.diag(np.diag(H)), g))
        promise = float(g @ delta - 0.5 * delta @ H @ delta)
        if promise < ENOUGH:
            break
        moved = z + _within_reach(model, delta)
        if _climbs(at, moved, score, here):
            return moved, damping / 10 if damping > 1e-6 else 0.0, promise
        damping = max(10 * damping, 1e-3)
    return None, damping, promise


def _afresh(
    model: Model, at: Likelihood, z: Array, here: Value, moving: NDArray[np.bool_]
) -> tuple[Array, Value]:
    """Return the likeliest of a place, itself with averages found as if from nowhere, and calmer.

    Where laws are simulated a latent force and the dashpots of deviations tell the same: with
    either large, nothing near is likelier with the other.

    Returns:
        Values (p,), and the model there.
    """
    latent = moving & [u.level and u.role == "system" for u in model.unknowns]
    scale = np.array([u.deviation for u in model.unknowns])
    options: list[tuple[Array, Sequence[LawAverages] | None]] = [(z, None)]
    if np.any(latent) and _simulated(here):
        options += [(z - np.where(latent, lower / scale, 0.0), here.averages) for lower in CALMER]
    best, place, least = here, z, here.log_likelihood - 0.5 * float(z @ z) + WORTH
    for tried, near in options:
        try:
            with np.errstate(all="ignore"):
                found = at(tried, False, None, near)
        except np.linalg.LinAlgError:
            continue
        value = found.log_likelihood - 0.5 * float(tried @ tried)
        if value > least:
            best, place, least = found, tried, value
    if best is here:
        return z, here
    told = _found(at, place, None, best.averages)
    return (z, here) if told is None else (place, told)


def _simulated(here: Value) -> bool:
    """Return whether laws are simulated."""
    return any(run.sampled.driven is not None for run in here.runs)


def _hessian(here: Value, moving: NDArray[np.bool_]) -> Array:
    """Return minus the log posterior's second derivatives (Gauss-Newton); 1 for what is held."""
    H = here.information + np.eye(len(moving))
    return np.where(np.outer(moving, moving), H, np.eye(len(moving)))


def _evidence(posterior: float, H: Array) -> float:
    """Return the log evidence by Laplace's method, of a log posterior and its curvature."""
    return posterior - 0.5 * float(np.linalg.slogdet(H)[1])


def _within_reach(model: Model, delta: Array) -> Array:
    """Return a step of which no unknown goes too far, and levels go as their own score says.

    A level s that should be s' has the step log s'/s = (s'^2/s^2 - 1) / 2 by Gauss and Newton,
    which is never below -1/2; the s' that they mean is one logarithm away.
    """
    out = delta.copy()
    for i, unknown in enumerate(model.unknowns):
        if unknown.level:
            change = unknown.deviation * delta[i]
            out[i] = 0.5 * np.log(max(1 + 2 * change, np.exp(-2 * FASTEST))) / unknown.deviation
    reach = np.array([LONGEST / u.deviation if u.log else LONGEST for u in model.unknowns])
    return out / max(1.0, float(np.max(np.abs(out) / reach)))


def _climbs(at: Likelihood, z: Array, score: float, here: Value) -> bool:
    """Return whether the model is likelier at other values.

    Derivatives cost ten times as much, and are not asked for; averages are those from where it is.
    But where laws with corners follow the motion, levels and averages hang on one another.
    """
    follow = any(run.begun for run in here.runs)
    # a step may lead anywhere; where nothing is finite it is not taken
    found = _found(at, z, here.averages, None if follow else here.averages, slopes=False)
    return found is not None and found.log_likelihood - 0.5 * float(z @ z) > score


def _found(
    at: Likelihood, z: Array, near: Sequence[LawAverages] | None,
    known: Sequence[LawAverages] | None = None, slopes: bool = True,
) -> Value | None:  # fmt: skip
    """Return the model at a place, with derivatives if asked for, None where it has none."""
    try:
        with np.errstate(all="ignore"):
            found = at(z, slopes, known, near)
    except np.linalg.LinAlgError:
        return None
    return found if np.all(np.isfinite(found.information)) else None
