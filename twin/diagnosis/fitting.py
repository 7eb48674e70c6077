"""Fit a hypothesis to the trials by maximum likelihood of its innovations."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.bench import SLACKS, Bench
from twin.diagnosis.filtering import Gain
from twin.diagnosis.hypothesis import Hypothesis, Unknown

Array = NDArray[np.float64]
Slopes = Mapping[tuple[int, str], Sequence[Array]]

STEP = 1e-3
"""Of the finite differences, as a share of each unknown's size."""


@dataclass(frozen=True)
class Fit:
    """A fitted hypothesis.

    Attributes:
        hypothesis: with the fitted values.
        std: standard deviation of each unknown, (unknowns,), in the fitted coordinates.
        log_likelihood: of the outputs given the inputs, profiled over the noise's covariances.
        log_prior: of all that has a prior.
        slack: force noise that the filter assumes.
        gains: one a trial.
        starts: initial states, one (n,) a trial.
        innovations: one (samples, m) a trial.
        samples: of all trials.
    """

    hypothesis: Hypothesis
    unknowns: tuple[Unknown, ...]
    std: Array
    log_likelihood: float
    log_prior: float
    slack: float
    gains: tuple[Gain, ...]
    starts: tuple[Array, ...]
    innovations: tuple[Array, ...]
    samples: int

    @property
    def log_posterior(self) -> float:
        """Log likelihood and log prior together."""
        return self.log_likelihood + self.log_prior

    @property
    def free(self) -> float:
        """Number of the found mechanisms' parameters that the trials determine (MacKay 1992).

        What a prior says already, and no trial says better, is no freedom to explain with.
        """
        count = float(sum(len(m.parameters) for m in self.hypothesis.found))
        for unknown, std in zip(self.unknowns, self.std, strict=True):
            if unknown.index >= len(self.hypothesis.base) and np.isfinite(unknown.prior_std):
                count -= min(1.0, float(std / unknown.prior_std) ** 2)
        return count

    @property
    def bic(self) -> float:
        """Bayesian information criterion (Schwarz 1978); priors count as they are."""
        return -2 * self.log_posterior + self.free * float(np.log(self.samples))


def covariances(innovations: Sequence[Array]) -> list[Array]:
    """Return the covariance of the innovations of each trial, (m, m)."""
    out = []
    for e in innovations:
        S = e.T @ e / len(e)
        out.append(S + 1e-18 * np.trace(S) * np.eye(len(S)))
    return out


def log_likelihood(innovations: Sequence[Array]) -> float:
    """Return the Gaussian log likelihood with each trial's covariance at its optimum."""
    total = 0.0
    for e in innovations:
        if not np.all(np.isfinite(e)):
            return -np.inf
        sign, logdet = np.linalg.slogdet(e.T @ e / len(e))
        if sign <= 0:
            return -np.inf
        total -= 0.5 * len(e) * (logdet + e.shape[1] * (1 + np.log(2 * np.pi)))
    return float(total)


def log_prior(unknowns: Sequence[Unknown], vector: Array) -> float:
    """Return the log prior of the unknowns that have one, up to a constant."""
    pulls = [(v - u.prior_mean) / u.prior_std for u, v in zip(unknowns, vector, strict=True)]
    return float(-0.5 * np.sum(np.square(pulls)))


class _Problem:
    """One hypothesis on one bench: gains, starts, innovations and their derivatives."""

    def __init__(self, bench: Bench, hypothesis: Hypothesis, slack: float) -> None:
        self.bench, self.hypothesis, self.slack = bench, hypothesis, slack
        self.unknowns = hypothesis.unknowns()
        self.gains = gains_of(bench, hypothesis, slack)
        self.Phi = bench.start_effects(hypothesis, self.gains)

    def residuals(self, vectors: Array, starts: Sequence[Array]) -> list[Array]:
        """Return the innovations at several values of the unknowns, by trial."""
        variants = [self.hypothesis.at(self.unknowns, v) for v in vectors]
        return self.bench.innovations(variants, self.gains, starts)


def gains_of(bench: Bench, hypothesis: Hypothesis, slack: float) -> tuple[Gain, ...]:
    """Return the gain of every trial."""
    plants = [row[0] for row in bench._plants([hypothesis])]
    return tuple(bench.gain(t, p, slack) for t, p in zip(bench.trials, plants, strict=True))


def lenient_gains(bench: Bench, hypothesis: Hypothesis, slack: float) -> tuple[Gain, ...]:
    """Return the gain of every trial, with more slack where the Riccati equation is too stiff.

    Raises:
        numpy.linalg.LinAlgError: no slack helps.
    """
    for level in (slack, *(s for s in SLACKS if s > slack)):
        try:
            return gains_of(bench, hypothesis, level)
        except np.linalg.LinAlgError:
            continue
    return gains_of(bench, hypothesis, slack)


def fit(
    bench: Bench,
    hypothesis: Hypothesis,
    slack: float,
    starts: Sequence[Array] | None = None,
    iterations: int = 6,
    tolerance: float = 0.05,
    slopes: Slopes | None = None,
) -> Fit:
    """Fit a hypothesis at a fixed slack by Gauss-Newton with a trust parameter.

    Args:
        bench: trials and model.
        hypothesis: with starting values.
        slack: force noise that the filter assumes, as a share of the inertia forces.
        starts: initial states to begin with, one (n,) a trial; found by least squares.
        iterations: at most.
        tolerance: stop when the log posterior gains less.
        slopes: derivatives of the innovations that are taken as known, by index and name of the
            unknown, one (samples, m) a trial; the others are found at each step.

    Raises:
        numpy.linalg.LinAlgError: no stationary filter, or one that runs away.
    """
    problem = _Problem(bench, hypothesis, slack)
    unknowns = problem.unknowns
    theta = hypothesis.vector(unknowns)
    size = np.array([u.size for u in unknowns])
    known = {
        i: slopes[u.index, u.name]
        for i, u in enumerate(unknowns)
        if slopes and (u.index, u.name) in slopes
    }
    free = [i for i in range(len(unknowns)) if i not in known]
    n = problem.Phi[0].shape[0]
    begin = fitting_starts(starts, n, len(bench.trials))
    found = problem.residuals(theta[None], begin)
    e = [row[0] for row in found]
    value = log_likelihood(e) + log_prior(unknowns, theta)
    trust = 1e-9
    H = np.eye(len(theta))
    for _ in range(iterations):
        steps = STEP * size[free]
        found = problem.residuals(theta + np.diag(STEP * size)[free], begin)
        J = []
        for i, row in enumerate(found):
            slope = np.empty((len(unknowns), *e[i].shape))
            slope[free] = (row - e[i]) / steps[:, None, None]
            for index, its in known.items():
                slope[index] = its[i]
            J.append(slope)
        if not all(np.isfinite(x).all() for x in (*e, *J)):
            raise np.linalg.LinAlgError("the filter's errors are not finite")
        H, gradient, solve_start = _normal(problem, begin, e, J, unknowns, theta)
        improved = False
        for _ in range(6):
            step = -size * _solved(H, gradient, size, trust)
            step = np.clip(step, -6 * size, 6 * size)
            trial_theta = theta + step
            trial_begin = solve_start(step)
            found = problem.residuals(trial_theta[None], trial_begin)
            trial_e = [row[0] for row in found]
            trial_value = log_likelihood(trial_e) + log_prior(unknowns, trial_theta)
            if trial_value > value:
                improved = True
                break
            trust = 100 * max(trust, 1e-7)
        if not improved:
            break
        gained = trial_value - value
        theta, begin, e, value = trial_theta, trial_begin, trial_e, trial_value
        trust = max(trust / 100, 1e-9)
        if gained < tolerance:
            break
    best = hypothesis.at(unknowns, theta)
    prior = log_prior(unknowns, theta)
    spread = size * np.sqrt(np.diag(np.linalg.pinv(H * np.outer(size, size), hermitian=True)))
    return Fit(
        best,
        unknowns,
        spread,
        value - prior,
        prior,
        slack,
        problem.gains,
        tuple(begin),
        tuple(e),
        bench.samples,
    )


def _solved(H: Array, gradient: Array, size: Array, trust: float) -> Array:
    """Return the damped Gauss-Newton step in units of the unknowns' sizes."""
    scaled = H * np.outer(size, size)
    damped = (
        scaled + trust * np.diag(np.diag(scaled)) + 1e-12 * np.trace(scaled) * np.eye(len(scaled))
    )
    return np.asarray(np.linalg.solve(damped, gradient * size))


def fitting_starts(starts: Sequence[Array] | None, n: int, trials: int) -> list[Array]:
    """Return initial states for n states: given ones with zeros for states they lack, or rest."""
    if starts is None:
        return [np.zeros(n) for _ in range(trials)]
    return [np.concatenate([s, np.zeros(n)])[:n] for s in starts]


def _normal(
    problem: _Problem,
    begin: Sequence[Array],
    e: Sequence[Array],
    J: Sequence[Array],
    unknowns: Sequence[Unknown],
    theta: Array,
) -> tuple[Array, Array, Callable[[Array], list[Array]]]:
    """Return the normal equations without the initial states, and the states that go with a step.

    Each trial's initial state enters its innovations linearly, so it is eliminated by a QR.
    """
    p = len(unknowns)
    precision = np.array([0.0 if np.isinf(u.prior_std) else u.prior_std**-2 for u in unknowns])
    mean = np.array([u.prior_mean for u in unknowns])
    H, gradient = np.diag(precision), precision * (theta - mean)
    parts = []
    for i, S in enumerate(covariances(e)):
        W = np.linalg.inv(np.linalg.cholesky(S)).T
        Jw = (J[i] @ W).reshape(p, -1).T
        ew = (e[i] @ W).reshape(-1)
        Pw = np.moveaxis(problem.Phi[i] @ W, 0, -1).reshape(-1, problem.Phi[i].shape[0])
        size = np.linalg.norm(Pw, axis=0)
        size[size == 0] = 1.0
        Q, R = np.linalg.qr(Pw / size)
        QJ, Qe = Q.T @ Jw, Q.T @ ew
        H = H + Jw.T @ Jw - QJ.T @ QJ
        gradient = gradient + Jw.T @ ew - QJ.T @ Qe
        parts.append((R, size, QJ, Qe))

    def solve(step: Array) -> list[Array]:
        return [
            b - np.linalg.lstsq(R, Qe + QJ @ step, rcond=1e-9)[0] / size
            for b, (R, size, QJ, Qe) in zip(begin, parts, strict=True)
        ]

    return H, gradient, solve
