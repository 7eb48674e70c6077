"""How well the drawing is known, by the recordings, where the user does not say.

Masses and stiffnesses of a structure as built lie about those of its drawing with one deviation,
the tolerance t, itself unknown: an empirical Bayes estimate (Efron and Morris 1973). A fit with
one tolerance gives the evidence of every other in closed form, for its posterior is nearly Gaussian
in these unknowns: with Lambda the inverse of their covariance, m their estimates, and D the new
prior variances over those of the fit,

    Lambda' = Lambda + D^-1 - 1,    b = Lambda m,
    gain = (log |Lambda| - log |Lambda'| - log |D| + b' Lambda'^-1 b - b' m) / 2.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import attempted
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.problem import Problem
from twin.estimation.fit import Fit
from twin.mechanisms import vocabulary

Array = NDArray[np.float64]

LEAST, SPREAD = 0.01, float(np.log(3.0))
"""Tolerance of a drawing whose parts are weighed and whose sections are measured, and the deviation
of the logarithm above it: a drawing off by 10 % lies two deviations away."""

GRID = LEAST * 10 ** (np.arange(13) / 6)
"""Tolerances that are compared, up to 100 %: neighbours differ by less than half a deviation."""

OFF = 0.15
"""Prior deviation of a mass or a stiffness that is itself a finding, as a share: that of its first
guesses."""


def odds_of(h: Hypothesis, found: Fit) -> float:
    """Return the log evidence of a fit, with the likeliest tolerance where the user says none.

    One that ran away is at no maximum, from which other tolerances could be told.
    """
    problem = h.problem
    if problem.told or not _count(problem) or found.code == "ran away":
        return found.log_evidence
    return found.log_evidence + max(_gained(problem, found, t, ()) + _prior(t) for t in GRID)


def at_its_tolerance(h: Hypothesis, found: Fit) -> tuple[Hypothesis, Fit]:
    """Return a fit with the tolerance of all masses and stiffnesses but those that stand out.

    One that is off by far more than the others is a finding to come, not the drawing's fault.
    """
    if h.problem.told or not _count(h.problem):
        return h, found
    tolerance = max(GRID, key=lambda t: _with_outliers(h.problem, found, float(t))[0])
    if tolerance == h.problem.tolerance:
        return h, found
    other, z = with_tolerance(h, found.z, float(tolerance))
    moved = attempted(other, z)
    return (h, found) if moved is None else (other, moved)


def with_tolerance(h: Hypothesis, z: Array, tolerance: float) -> tuple[Hypothesis, Array]:
    """Return a hypothesis with another tolerance, and the values that are the same, (p,)."""
    there = z.copy()
    there[: _count(h.problem)] *= h.problem.tolerance / tolerance
    return replace(h, problem=replace(h.problem, tolerance=tolerance)), there


def standing_out(h: Hypothesis, found: Fit) -> tuple[float, tuple[int, ...]]:
    """Return the likeliest tolerance of all but those that stand out, and these, by index.

    Args:
        h: what was fitted; where the user says the tolerance, none stand out.
        found: its fit.
    """
    if h.problem.told or not _count(h.problem):
        return h.problem.tolerance, ()
    told = [(*_with_outliers(h.problem, found, float(t)), float(t)) for t in GRID]
    _, out, tolerance = max((one for one in told if one[1]), default=(0.0, (), h.problem.tolerance))
    return tolerance, out


def far_off(problem: Problem, z: Array) -> bool:
    """Return whether a fit has moved masses and stiffnesses by more than a drawing errs.

    What it lacks is then likely to be what they stand for, and is in another valley than it is:
    that is looked for from the nominal twin, too.

    Args:
        problem: the estimation problem.
        z: values of the unknowns, base first, (p,).
    """
    moved = problem.tolerance * z[: _count(problem)]
    return bool(len(moved) and np.sqrt(np.mean(moved**2)) > LEAST)


def in_words(problem: Problem) -> str:
    """Say what tolerance the recordings show."""
    return (
        f"masses and stiffnesses are taken as known to {100 * problem.tolerance:.2g} %, "
        "by the recordings; --tolerance says it otherwise"
    )


def _count(problem: Problem) -> int:
    return len(problem.stiffnesses) + len(problem.masses)


def _prior(tolerance: float) -> float:
    return float(-0.5 * (np.log(tolerance / LEAST) / SPREAD) ** 2)


def _with_outliers(problem: Problem, found: Fit, tolerance: float) -> tuple[float, tuple[int, ...]]:
    """Return the gain with a tolerance, those left out of it that pay for it [nat], and these."""
    count = _count(problem)
    cost = float(np.log(count * len(vocabulary())))
    out: tuple[int, ...] = ()
    best = _gained(problem, found, tolerance, out)
    while len(out) < count:
        tried = {
            i: _gained(problem, found, tolerance, (*out, i)) - cost * (len(out) + 1)
            for i in range(count)
            if i not in out
        }
        index = max(tried, key=lambda i: tried[i])
        if tried[index] <= best:
            break
        out, best = (*out, index), tried[index]
    return best + _prior(tolerance), out


def _gained(problem: Problem, found: Fit, tolerance: float, out: tuple[int, ...]) -> float:
    """Return the log evidence gained with another tolerance [nat].

    Args:
        problem: its tolerance is that of the fit.
        found: the fit.
        tolerance: another one.
        out: which of the unknowns are off by far more, by index.
    """
    count = _count(problem)
    widths = np.full(count, tolerance)
    for index in out:
        widths[index] = np.hypot(tolerance, OFF)
    D = (widths / problem.tolerance) ** 2
    mean = found.z[:count]
    precision = np.linalg.inv(found.covariance[:count, :count])
    changed = precision + np.diag(1 / D - 1)
    b = precision @ mean
    _, before = np.linalg.slogdet(precision)
    sign, after = np.linalg.slogdet(changed)
    if sign <= 0:
        return -np.inf
    quadratic = float(b @ np.linalg.solve(changed, b)) - float(b @ mean)
    return 0.5 * float(before - after - np.sum(np.log(D)) + quadratic)
