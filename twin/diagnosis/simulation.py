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
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.motion import Motion, motion_of
from twin.errors import NoLikelihoodError
from twin.estimation.fit import Fit, fit
from twin.estimation.kalman import silent
from twin.estimation.law_averages import LawAverages
from twin.estimation.likelihood import Value
from twin.estimation.parallel import each
from twin.estimation.passing import Run, passed
from twin.estimation.sensitivities import plants_of, slopes_of

Array = NDArray[np.float64]

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
    def free(self) -> NDArray[np.bool_]:
        """Which unknowns are of the simulation: neither noise nor discrepancy, (p,)."""
        return np.array([
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
        return tuple(motion_of(passed, n, step_s) for passed in self.runs(z))

    def law_forces(self, z: Array) -> Array:
        """Return the RMS force of each law that was found, (l,)."""
        f = np.vstack([run.f for run in self.runs(z)])
        return np.asarray(np.sqrt(np.mean(f[:, : len(self.hypothesis.laws)] ** 2, axis=0)))

    def runs(self, z: Array, free: NDArray[np.bool_] | None = None) -> list[Run]:
        """Return the simulation of each recording, from rest.

        Args:
            z: values of the unknowns, (p,).
            free: those with respect to which residuals are derived, (p,); none without.
        """
        here = self.hypothesis.assemble(z)
        plants = plants_of(here, self.hypothesis)
        none = LawAverages()
        slopes = free is not None and slopes_of(
            self.hypothesis, z, here, plants, [none] * len(here.trials), free, listens=False
        )

        def one(index: int) -> Run:
            plant = plants[here.which[index]]
            own = slopes[index] if slopes else None
            found = passed(here, index, plant, silent(plant), none, own)
            if own is None:
                return found
            de = np.zeros((*found.e.shape, len(self.free)))
            de[:, :, own.columns] = found.de
            return replace(found, de=de)

        with np.errstate(all="ignore"):
            return each(one, len(here.trials))

    def fitted(
        self, z: Array, free: NDArray[np.bool_] | None = None, hopeless: float = -np.inf
    ) -> Fit:
        """Return the maximum a posteriori estimate from values z, (p,), of ``free`` unknowns.

        One that will not reach the log evidence ``hopeless`` is given up (``fit``).

        Raises:
            NoLikelihoodError: there is no simulation where it begins.
        """
        return fit(self.hypothesis, z, free=self.free if free is None else free,
                   likelihood=self.value, hopeless=hopeless)  # fmt: skip

    def value(
        self, z: Array, derivatives: bool = True, averages: object = None, near: object = None
    ) -> Value:
        """Return the log likelihood up to a constant, and its derivatives, as ``fit`` asks for it.

        Raises:
            NoLikelihoodError: a simulation that is not finite.
        """
        runs = self.runs(z, self.free if derivatives else None)
        r = np.vstack([run.e for run in runs])
        if not np.all(np.isfinite(r)):
            raise NoLikelihoodError("the simulation is not finite")
        log_det = np.linalg.slogdet(self.covariance(r))[1]
        p = len(self.free)
        gradient, information = np.zeros(p), np.zeros((p, p))
        if derivatives:
            white, slopes = self.whitened(runs)
            gradient, information = -slopes.T @ white, slopes.T @ slopes
        return Value(-0.5 * self.tau * len(r) * float(log_det), gradient, information, (), ())

    def covariance(self, r: Array) -> Array:
        """Return S, (m, m)."""
        return np.asarray(r.T @ r / len(r) + np.diag(self.floor))

    def whiten(self, change: Array, r: Array) -> Array:
        """Return changes of the residuals r, (N, m, c), by their covariance, as rows, (N m, c)."""
        root = np.sqrt(self.tau) * np.linalg.inv(np.linalg.cholesky(self.covariance(r)))
        return np.einsum("ij,njc->nic", root, change).reshape(-1, change.shape[-1])

    def whitened(self, runs: Sequence[Run]) -> tuple[Array, Array]:
        """Return residuals and their slopes by the unknowns, whitened, (N m,) and (N m, p)."""
        r, slopes = (np.vstack(part) for part in zip(*((a.e, a.de) for a in runs), strict=True))
        return self.whiten(r[:, :, None], r)[:, 0], self.whiten(slopes, r)


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
