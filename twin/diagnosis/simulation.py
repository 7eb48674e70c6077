"""The output error of a hypothesis: what a simulation from rest leaves of the outputs.

    log p(y | z) = -tau N/2 log det S,    S = 1/N sum_k r_k r_k^T,    r = y - simulation(z)

with the covariance S of all outputs together at its maximum. Where the inputs are measured without
noise this estimate is consistent whatever colour the rest has (Ljung 1999, section 8.4), for it
never listens to the outputs: what no law explains cannot drive the structure as process noise. A
rest that is correlated in time has fewer independent samples than N; tau is their share,
1 / (1 + 2 sum rho_k^2) with its autocorrelation rho (Bayley and Hammersley 1946).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.motion import Motion
from twin.estimation.kalman import Gains
from twin.estimation.parallel import each
from twin.estimation.passing import Run, run
from twin.estimation.sensitivities import plants_of

Array = NDArray[np.float64]

STEP = 1e-4
"""Step of the differences in prior deviations: between rounding and curvature."""

LEAST_GAIN = 0.05
"""Gain in log posterior [nat] below which a step is not worth another."""

FARTHEST = 1.0
"""Farthest step of an unknown, in prior deviations: the simulation is followed no farther."""

TRIES = 6
"""Steps that may fail to climb, each damped ten times more."""

WINDOW = 5.0
"""Correlation times over which the autocorrelation is summed (Sokal 1997)."""


@dataclass(frozen=True)
class OutputError:
    """A hypothesis judged by its simulation.

    Attributes:
        hypothesis: base, laws and instruments.
        tau: share of the samples that count.
    """

    hypothesis: Hypothesis
    tau: float = 1.0

    @cached_property
    def free(self) -> NDArray[np.intp]:
        """Unknowns of the simulation: neither noise nor discrepancy."""
        return np.flatnonzero([
            u.role != "noise" and not u.name.startswith("discrepancy")
            for u in self.hypothesis.unknowns
        ])  # fmt: skip

    @cached_property
    def floor(self) -> Array:
        """Variances that the outputs' own noise has at least, (m,)."""
        return np.asarray(np.mean(self.hypothesis.problem.output_levels**2, axis=0))

    def residuals(self, z: Array) -> list[Array]:
        """Return what the simulation leaves of each recording, (samples, m)."""
        return [run.e for run in self.runs(z)]

    def motion(self, z: Array) -> tuple[Motion, ...]:
        """Return the simulated motion of each recording."""
        n, step_s = len(self.hypothesis.problem.model.coordinates), self.hypothesis.problem.step_s
        out = []
        for passed in self.runs(z):
            q, v = passed.x[:, :n], passed.x[:, n : 2 * n]
            out.append(Motion(q, v, np.gradient(v, step_s, axis=0)))
        return tuple(out)

    def law_forces(self, z: Array) -> Array:
        """Return the RMS force of each law that was found, (l,)."""
        f = np.vstack([run.f for run in self.runs(z)])
        return np.asarray(np.sqrt(np.mean(f[:, : len(self.hypothesis.laws)] ** 2, axis=0)))

    def runs(self, z: Array) -> list[Run]:
        """Return the simulation of each recording, from rest."""
        here = self.hypothesis.assemble(z)
        plants = plants_of(here, self.hypothesis)

        def one(index: int) -> Run:
            plant, trial = plants[here.which[index]], here.trials[index]
            n, m, w = len(plant.A), trial.y.shape[1], plant.W.shape[1]
            deaf = Gains(
                np.zeros((1, n, m)), np.zeros((1, w, m)), np.eye(m)[None], np.zeros((n, n))
            )
            return run(here, trial, plant, deaf)

        with np.errstate(all="ignore"):
            return each(one, len(here.trials))

    def log_posterior(self, z: Array) -> tuple[float, Array]:
        """Return it up to a constant, and the residuals of all recordings, (N, m)."""
        try:
            r = np.vstack(self.residuals(z))
        except (ValueError, np.linalg.LinAlgError):
            return -np.inf, np.zeros((0, 0))
        if not np.all(np.isfinite(r)):
            return -np.inf, r
        log_det = np.linalg.slogdet(self.covariance(r))[1]
        own = z[self.free]
        return -0.5 * self.tau * len(r) * float(log_det) - 0.5 * float(own @ own), r

    def covariance(self, r: Array) -> Array:
        """Return S, (m, m)."""
        return np.asarray(r.T @ r / len(r) + np.diag(self.floor))

    def slopes(self, z: Array, r: Array, moving: NDArray[np.intp]) -> Array:
        """Return derivatives of the residuals, (N, m, p)."""
        columns = []
        for i in moving:
            near = z.copy()
            near[i] += STEP
            columns.append((np.vstack(self.residuals(near)) - r) / STEP)
        return np.stack(columns, axis=-1)

    def hessian(self, r: Array, J: Array) -> tuple[Array, Array]:
        """Return minus the log posterior's second derivatives, and the score without the prior."""
        inverse = np.linalg.inv(np.linalg.cholesky(self.covariance(r)))
        J_white = np.einsum("ij,njp->nip", inverse, J).reshape(-1, J.shape[-1])
        r_white = (r @ inverse.T).ravel()
        H = self.tau * J_white.T @ J_white + np.eye(J.shape[-1])
        return H, -self.tau * J_white.T @ r_white


@dataclass(frozen=True)
class Simulated:
    """A maximum of the posterior.

    Attributes:
        z: all unknowns, (p,).
        log_posterior, log_evidence: by Laplace's method.
        covariance: of ``OutputError.free``.
        residuals: of all recordings, (N, m).
    """

    z: Array
    log_posterior: float
    log_evidence: float
    covariance: Array
    residuals: Array


def climb(
    model: OutputError, z: Array, most: int, moving: NDArray[np.intp] | None = None
) -> Simulated | None:
    """Climb the posterior by damped Gauss-Newton steps; None where there is no simulation.

    Args:
        model: what is fitted.
        z: where to begin, (p,).
        most: steps at most.
        moving: unknowns that move; all free ones without.
    """
    own = model.free if moving is None else moving
    value, r = model.log_posterior(z)
    if not np.isfinite(value):
        return None
    damping, J = 1e-3, model.slopes(z, r, own)
    for _ in range(most):
        if not np.all(np.isfinite(J)):
            return None
        H, score = model.hessian(r, J)
        score = score - z[own]
        for _ in range(TRIES):
            step = np.linalg.solve(H + damping * np.diag(np.diag(H)), score)
            step /= max(1.0, float(np.max(np.abs(step))) / FARTHEST)
            moved = z.copy()
            moved[own] += step
            found, other = model.log_posterior(moved)
            if found > value:
                break
            damping *= 10
        else:
            break
        gain, z, value, r = found - value, moved, found, other
        damping = max(damping / 10, 1e-6)
        J = model.slopes(z, r, own)
        if gain < LEAST_GAIN:
            break
    if not np.all(np.isfinite(J)):
        return None
    H, _ = model.hessian(r, J)
    evidence = value - 0.5 * float(np.linalg.slogdet(H)[1])
    return Simulated(z, value, evidence, np.asarray(np.linalg.inv(H)), r)


def independent_share(pieces: Sequence[Array]) -> float:
    """Return the share of samples that count where the rest is correlated in time.

    Args:
        pieces: residuals of each recording, (samples, m).
    """
    r = np.vstack([p / np.sqrt(np.mean(p**2)) for p in pieces])
    _, vectors = np.linalg.eigh(r.T @ r)
    total, weight = 0.0, 0.0
    for piece in pieces:
        x = piece @ vectors[:, -1]
        length = 2 * len(x)
        spectrum = np.abs(np.fft.rfft(x - x.mean(), length)) ** 2
        rho = np.fft.irfft(spectrum, length)[: len(x)]
        squares = 1 + 2 * np.cumsum((rho[1:] / rho[0]) ** 2)
        enough = np.flatnonzero(np.arange(1, len(x)) >= WINDOW * squares)
        total += float(squares[enough[0]] if len(enough) else squares[-1]) * len(x)
        weight += len(x)
    return weight / total
