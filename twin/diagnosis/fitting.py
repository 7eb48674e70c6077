"""Fit a hypothesis to the trials by maximum likelihood of its innovations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.bench import Bench
from twin.diagnosis.filtering import Gain
from twin.diagnosis.hypothesis import Hypothesis, Unknown
from twin.physics.mechanism import Disturbance

Array = NDArray[np.float64]

SLACKS = (1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3)
"""Force noise that a filter may assume beyond the measured one, as a share of inertia forces."""

STEP = 1e-3
"""Of the finite differences, as a share of each unknown's size."""


@dataclass(frozen=True)
class Fit:
    """A fitted hypothesis.

    Attributes:
        hypothesis: with the fitted values.
        std: standard deviation of each unknown, (unknowns,), in the fitted coordinates.
        log_likelihood: of the outputs given the inputs, profiled over the noise's covariances.
        log_prior: of the base's deviations.
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
    def free(self) -> int:
        """Number of parameters that the found mechanisms have."""
        return sum(len(m.parameters) for m in self.hypothesis.found)

    @property
    def bic(self) -> float:
        """Bayesian information criterion (Schwarz 1978); the base's priors count as they are."""
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
    """Return the log prior of the base's deviations, up to a constant."""
    pulls = [(v - u.prior_mean) / u.prior_std for u, v in zip(unknowns, vector, strict=True)]
    return float(-0.5 * np.sum(np.square(pulls)))


class _Problem:
    """One hypothesis on one bench: gains, starts, innovations and their derivatives."""

    def __init__(self, bench: Bench, hypothesis: Hypothesis, slack: float) -> None:
        self.bench, self.hypothesis, self.slack = bench, hypothesis, slack
        self.unknowns = hypothesis.unknowns()
        self.gains = gains_of(bench, hypothesis, slack)
        self.Phi = bench.start_effects(hypothesis, self.gains)

    def residuals(
        self, vectors: Array, starts: Sequence[Array]
    ) -> tuple[list[Array], list[Hypothesis]]:
        variants = [self.hypothesis.at(self.unknowns, v) for v in vectors]
        return self.bench.innovations(variants, self.gains, starts), variants


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
) -> Fit:
    """Fit a hypothesis at a fixed slack by Gauss-Newton with a trust parameter.

    Args:
        bench: trials and model.
        hypothesis: with starting values.
        slack: force noise that the filter assumes, as a share of the inertia forces.
        starts: initial states to begin with, one (n,) a trial; found by least squares.
        iterations: at most.
        tolerance: stop when the log posterior gains less.
    """
    problem = _Problem(bench, hypothesis, slack)
    unknowns = problem.unknowns
    theta = hypothesis.vector(unknowns)
    size = np.array([u.size for u in unknowns])
    n = problem.Phi[0].shape[0]
    begin = _fitting(starts, n, len(bench.trials))
    found, variants = problem.residuals(theta[None], begin)
    e = [row[0] for row in found]
    value = log_likelihood(e) + log_prior(unknowns, theta)
    trust = 1e-9
    H = np.eye(len(theta))
    for _ in range(iterations):
        steps = np.diag(STEP * size)
        found, _ = problem.residuals(theta + steps, begin)
        J = [
            np.moveaxis((row - e[i][None]) / (STEP * size)[:, None, None], 0, -1)
            for i, row in enumerate(found)
        ]
        H, gradient, solve_start = _normal(problem, begin, e, J, unknowns, theta)
        improved = False
        for _ in range(4):
            step = -size * _solved(H, gradient, size, trust)
            step = np.clip(step, -6 * size, 6 * size)
            trial_theta = theta + step
            trial_begin = solve_start(step)
            found, variants = problem.residuals(trial_theta[None], trial_begin)
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


def _fitting(starts: Sequence[Array] | None, n: int, trials: int) -> list[Array]:
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
        Jw = np.einsum("kmp,mw->kwp", J[i], W).reshape(-1, p)
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


DISTURBANCE_STEPS = (0.01, 0.1, 0.4, 2.5, 10.0)
"""Factors by which the strength and the bandwidth of an unmeasured force are tried."""


def with_disturbances(bench: Bench, found: Fit) -> Fit:
    """Return the fit with strengths and bandwidths of its unmeasured forces that it likes best.

    They act on the filter's gain alone, which the Gauss-Newton steps hold fixed.
    """
    best = found
    for index, mechanism in enumerate(found.hypothesis.found):
        if not isinstance(mechanism, Disturbance):
            continue
        for name in ("rms", "bandwidth"):
            here = best.hypothesis.found[index]
            for factor in DISTURBANCE_STEPS:
                changed = here.with_values({name: factor * here.values[name]})
                mechanisms = list(best.hypothesis.found)
                mechanisms[index] = changed
                hypothesis = replace(found.hypothesis, found=tuple(mechanisms))
                try:
                    gains = gains_of(bench, hypothesis, best.slack)
                except np.linalg.LinAlgError:
                    continue
                rows = bench.innovations([hypothesis], gains, best.starts)
                e = tuple(row[0] for row in rows)
                value = log_likelihood(e)
                if value > best.log_likelihood:
                    best = replace(
                        best, hypothesis=hypothesis, log_likelihood=value, gains=gains,
                        innovations=e,
                    )  # fmt: skip
    return best


def with_slack(bench: Bench, found: Fit, slacks: Sequence[float] = SLACKS) -> Fit:
    """Return the fit with the slack that its likelihood likes best, parameters unchanged."""
    best = found
    for slack in slacks:
        if slack == found.slack:
            continue
        try:
            gains = gains_of(bench, found.hypothesis, slack)
        except np.linalg.LinAlgError:
            continue
        rows = bench.innovations([found.hypothesis], gains, found.starts)
        e = tuple(row[0] for row in rows)
        value = log_likelihood(e)
        if value > best.log_likelihood:
            best = replace(found, log_likelihood=value, slack=slack, gains=gains, innovations=e)
    return best


def refined(
    bench: Bench,
    starts: Sequence[Hypothesis],
    slack: float,
    states: Sequence[Array] | None = None,
    rounds: int = 6,
    iterations: int = 3,
) -> Fit:
    """Fit parameters and slack in turn until neither gains.

    A slack that falls as the fit improves is what keeps it out of local minima: the filter follows
    the data closely at first and leaves more and more to the model.

    Args:
        bench: trials and model.
        starts: the same hypothesis at one or more starting points; the best one is taken.
        slack: to begin with.
        states: initial states, one (n,) a trial.
        rounds: at most.
        iterations: Gauss-Newton steps in each.
    """
    hypothesis = max(starts, key=lambda h: _posterior(bench, h, slack, states))
    try:
        best = fit(bench, hypothesis, slack, states, iterations)
    except np.linalg.LinAlgError:
        # with no noise to speak of the Riccati equation can be too stiff
        best = fit(bench, hypothesis, max(100 * slack, SLACKS[2]), states, iterations)
    for _ in range(rounds):
        near = [s for s in SLACKS if best.slack / 35 < s < best.slack * 35]
        moved = with_disturbances(bench, with_slack(bench, best, near))
        before = best.log_posterior
        try:
            best = fit(bench, moved.hypothesis, moved.slack, moved.starts, iterations)
        except np.linalg.LinAlgError:
            return moved
        if moved.slack == best.slack and best.log_posterior - before < 1.0:
            return best
    return best


def _posterior(
    bench: Bench, hypothesis: Hypothesis, slack: float, states: Sequence[Array] | None
) -> float:
    """Return the log posterior of a hypothesis as it stands."""
    try:
        gains = gains_of(bench, hypothesis, slack)
    except np.linalg.LinAlgError:
        return -np.inf
    begin = _fitting(states, len(gains[0].filtered), len(bench.trials))
    unknowns = hypothesis.unknowns()
    rows = bench.innovations([hypothesis], gains, begin)
    return log_likelihood([r[0] for r in rows]) + log_prior(unknowns, hypothesis.vector(unknowns))
