"""The state before the first sample, from the samples that follow.

With the innovations e(k) of the predictor and their slopes H(k) with respect to that state, whose
prior covariance is P, the maximum of its posterior is where

    x0 + P sum_k H_k^T S_k^-1 e_k = 0

(fixed-point smoothing; Anderson and Moore 1979, section 7.2). With laws that are not linear e and H
depend on x0, so it is found by damped Gauss-Newton steps, with the predictor of a state that is
known to begin with.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from twin.estimation.density import density
from twin.estimation.kalman import gains
from twin.estimation.law_averages import LawAverages, Start
from twin.estimation.model import Assembly, Trial
from twin.estimation.passing import run
from twin.estimation.system import Noise, Sampled

Array = NDArray[np.float64]
Passed = Callable[[Array, bool], tuple[float, Array, Array]]
"""passed(s, sloped): half the sum of squares after a state s in deviations of the prior, (k,), and,
where it is sloped, its gradient (k,) and the slopes of what is squared, (values, k)."""

BEGINNING, FEWEST = 1024, 64
"""Samples that tell of the state before the first one: ten time constants of a mode with 1 % of
damping at a sixtieth of the sampling rate; what comes later a predictor has forgotten. And those
that are asked first where nothing is known, a period of such a mode, then twice as many: over few
of them friction holds and lets go seldom, and the posterior has few maxima."""

DIRECTIONS = 4
"""In which the first few samples are tried from both sides of the prior's mean: displacement and
rate of two modes. From the mean alone friction begins as it never did in a fifth of the cases."""

STEPS, ENOUGH = 30, 0.01
"""Passes to find that state at most, and the gain in log posterior [nat] below which one is not
worth another."""

ROUGHLY = 1.0
"""The gain [nat] where maxima are only told apart, or others go on from there: those that matter
are further apart than Laplace's method is off by, and the best is climbed to its top."""

FIRST_DAMPING = 1e-4
"""Of the steps, once one does not climb; ten times as much for each that does not, either."""


def estimated_start(
    here: Assembly, trial: Trial, plant: Sampled, noise: Noise, averages: LawAverages,
    steps: int = STEPS, near: Array | None = None, slopes: Array | None = None,
    guess: Array | None = None, roughly: bool = False,
) -> Start:  # fmt: skip
    """Return the state before the first sample with the greatest posterior.

    Args:
        here: for laws and numbers.
        trial: the recording.
        plant: its sampled system.
        noise: levels, and the prior covariance of that state.
        averages: what the laws do on the average.
        steps: passes at most.
        near: a state that it is near to, (n,); found from few samples on without.
        slopes: those found there, (values, k), to go on with (a chord step); found without.
        guess: a state that it may be near to, (n,): that of a twin with less in it.
        roughly: whether it may be ``ROUGHLY`` there, where it is not near one.
    """
    root = _root_of_uncertain(noise.start)
    beside = partial(_beside, here, trial, plant, noise, averages, root)
    if near is not None:
        return _climbed(beside(BEGINNING, slopes), root, steps, near, ENOUGH)[0]
    # blows, and the mean of the prior, may lead to another maximum than few samples do
    measured = np.flatnonzero(~np.isnan(trial.y).all(axis=1))
    begin, few, state = int(measured[0]) if len(measured) else 0, FEWEST, guess
    beginnings = _beginnings(plant, root)
    while guess is None and begin + few < min(BEGINNING, len(trial.y)):
        passed = beside(begin + few)
        found = [_climbed(passed, root, steps, begun, ROUGHLY) for begun in beginnings]
        state = min(found, key=lambda climbed: climbed[1])[0].state
        beginnings, few = [state], 2 * few
    passed = beside(BEGINNING)
    both = [_climbed(passed, root, steps, begun, ROUGHLY) for begun in (state, None)]
    best = min(both, key=lambda climbed: climbed[1])[0]
    return best if roughly else _climbed(passed, root, steps, best.state, ENOUGH)[0]


def _beginnings(plant: Sampled, root: Array) -> list[Array]:
    """Return the prior's mean, and states a deviation to both sides that move the laws' ports most.

    Args:
        plant: the sampled system.
        root: of the prior's covariance, (n, k).
    """
    if plant.driven is None:  # laws that follow the motion are led by it
        return [np.zeros(len(root))]
    moved = np.sum((plant.driven.simulated.system.rate @ root) ** 2, axis=0)
    most = np.argsort(-moved, kind="stable")[: min(DIRECTIONS, np.count_nonzero(moved))]
    return [np.zeros(len(root)), *(side * root[:, i] for i in most for side in (1.0, -1.0))]


def _beside(
    here: Assembly, trial: Trial, plant: Sampled, noise: Noise, averages: LawAverages, root: Array,
    samples: int, slopes: Array | None = None,
) -> Passed:  # fmt: skip
    """Return what tells how likely the first samples are after a state, in deviations (k,).

    Slopes that are known are not asked for again.
    """
    first = trial.until(samples)
    blur = averages.blur
    averages = replace(averages, blur=None if blur is None else blur[:samples])
    kicks = {k: more for k, more in averages.kicks.items() if k < samples}
    known = replace(noise, start=0 * noise.start, kicks=kicks)
    gain = gains(averages.filtering(plant), known, equivalent=averages.equivalent,
                 missing=first.missing)  # fmt: skip
    k = root.shape[1]
    told = slopes if slopes is not None and slopes.shape == (first.y.size, k) else None

    def passed(s: Array, sloped: bool) -> tuple[float, Array, Array]:
        nowhere = np.inf, np.zeros(k), np.zeros((first.y.size, k))  # laws run away from there
        with np.errstate(all="ignore"):
            moved = root if sloped and told is None else None
            result = run(here, first, plant, gain, x0=root @ s, dx0=moved, averages=averages)
            try:
                part = density(result.e, first.y, result.gains.innovation, averages.blur)
            except np.linalg.LinAlgError:
                return nowhere
            cost = 0.5 * float(np.sum(part.white**2) + s @ s)
            if not sloped:
                return (cost if np.isfinite(cost) else np.inf), *nowhere[1:]
            found = part.whitened(result.de) if told is None else told
            gradient = found.T @ part.white.ravel() + s
        if not (np.isfinite(cost) and np.all(np.isfinite(found.T @ found))):
            return nowhere
        return cost, gradient, found

    return passed


def _climbed(
    passed: Passed, root: Array, steps: int, near: Array | None, enough: float
) -> tuple[Start, float]:
    """Return where damped steps climb to from a state nearby, and minus its log posterior there."""
    s: Array = np.zeros(root.shape[1])
    damping = 0.0
    if near is not None and np.all(np.isfinite(near)):
        s = np.asarray(np.linalg.lstsq(root, near, rcond=None)[0], float)
    cost, gradient, slopes = passed(s, True)
    H = _curvature(slopes)
    for number in range(steps):
        try:
            step = -np.linalg.solve(H + damping * np.diag(np.diag(H)), gradient)
        except np.linalg.LinAlgError:
            break
        if -step @ (gradient + 0.5 * H @ step) < enough:  # what it promises
            break
        other, _, _ = passed(s + step, False)
        if not other < cost:
            damping = max(10 * damping, FIRST_DAMPING)
            continue
        gained, s, damping, cost = cost - other, s + step, damping / 10, other
        if gained < enough or number == steps - 1:
            break
        cost, gradient, slopes = passed(s, True)
        H = _curvature(slopes)
    sign, volume = np.linalg.slogdet(H)
    # of laws that all but run away rounding leaves no curvature: nothing tells for such a state
    odds = -0.5 * float(s @ s + volume) if sign > 0 else -np.inf
    return Start(np.asarray(root @ s), odds, slopes), cost


def _curvature(slopes: Array) -> Array:
    """Return the curvature of a log posterior, (k, k), whose prior has deviations of one."""
    return np.asarray(slopes.T @ slopes + np.eye(slopes.shape[1]))


def _root_of_uncertain(covariance: Array) -> Array:
    """Return a square root of a covariance, (n, k), of the k states that are not known."""
    uncertain = np.flatnonzero(np.diag(covariance) > 0)
    root = np.zeros((len(covariance), len(uncertain)))
    root[uncertain] = root_of(covariance[np.ix_(uncertain, uncertain)])
    return root


def root_of(covariance: Array) -> Array:
    """Return a square root of a covariance, (n, n)."""
    values, vectors = np.linalg.eigh((covariance + covariance.T) / 2)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0)))
