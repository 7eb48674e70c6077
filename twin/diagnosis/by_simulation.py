"""The search where the ground alone shakes a structure whose numbers are not known.

A motion that is strong throughout has no gentle part on which a linear twin could be calibrated,
and a predictor that listens to the outputs lets process noise stand for what the twin lacks. Here
every hypothesis is judged by its simulation (``simulation``): laws are added at ports while one
pays for itself, by a score test of every law at every port, a fit of the most promising, and
evidence by Laplace's method, at the price that any law at any place is as likely as another.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import added, moved_to
from twin.diagnosis.candidates import Candidate, scales_of
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.problem import Problem
from twin.diagnosis.search import Found, Offer
from twin.diagnosis.simulation import OutputError, Simulated, climb, independent_share
from twin.diagnosis.stated import stated_error
from twin.diagnosis.valleys import Score
from twin.errors import ModelError
from twin.estimation.fit import Fit
from twin.mechanisms.mechanism import Law
from twin.model.linear import LinearModel

Array = NDArray[np.float64]

WIDTH = 4
"""Candidates of a screening that are fitted in a search step."""

MOST = 2
"""Laws at most: a simulation of strong motion tells no third one from what the first two lack."""

ENOUGH = 3.0
"""Log odds [nat] by which a law must pay for itself: 1 to 20."""

SMALL = 0.1
"""Share of a first guess at which its direction is taken: a law that slips has none at zero."""

STEPS = 30
"""Steps of a fit at most."""

STRENGTHS = (0.1, 10.0)
"""Strengths in first guesses between which a fit begins."""

QUIET = -4.0
"""Process noise in prior deviations: none."""


@dataclass(frozen=True)
class Fitted:
    """A hypothesis and its maximum; ``log_odds`` is its evidence less what the set costs.

    ``tau`` is the share of the samples that count.
    """

    hypothesis: Hypothesis
    found: Simulated
    log_odds: float
    tau: float


@dataclass(frozen=True)
class Searched:
    """What the search found, and the error that it states beforehand.

    Attributes:
        found: as any search returns it.
        stated: NRMSE that the recordings that were not seen will have (``stated_error``).
    """

    found: Found
    stated: float


def search_by_simulation(
    problem: Problem, unseen: Problem, offer: Offer,
    tell: Callable[[str], None] = lambda message: None,
) -> Searched:  # fmt: skip
    """Find the laws whose simulations explain the recordings.

    Args:
        problem: the estimation problem.
        unseen: recordings of which the error is stated; their outputs are not used.
        offer: returns all candidates, given the motion of each recording.
        tell: is told each step.
    """
    empty = Hypothesis(problem)
    begin = np.zeros(len(empty.unknowns))
    nothing = best = _calibrated(empty, begin)
    tau = nothing.tau
    tried: list[Fitted] = []
    screened = []
    for step in range(MOST):
        tell(f"search step {step + 1}: screening")
        moved = OutputError(best.hypothesis).motion(best.found.z)
        here = replace(best.hypothesis, scales=scales_of(problem, moved))
        own = {(m.name, m.place) for m in here.mechanisms}
        candidates = [c for c in offer(moved, ()) if isinstance(c.starts[0], Law)
                      and c.label not in own]  # fmt: skip
        cost = float(np.log(max(len(candidates), 2)))
        scores = _screened(OutputError(here, tau), best.found, candidates)
        screened.append(tuple(scores))
        fits = []
        for number, score in enumerate([s for s in scores if s.gain > cost][:WIDTH]):
            what = " at ".join(score.candidate.label)
            tell(f"search step {step + 1}: fitting {what} ({number + 1})")
            grown = added(here, score.candidate, score.start)
            z = moved_to(grown, here, best.found.z, score.start)
            fitted = climb(OutputError(grown, tau), z, STEPS)
            if fitted is not None:
                odds = fitted.log_evidence - cost * len(grown.mechanisms)
                fits.append(Fitted(grown, fitted, odds, tau))
        tried += fits
        top = max(fits, key=lambda f: f.log_odds, default=best)
        if top.log_odds <= best.log_odds + ENOUGH:
            break
        best = top
    tell("stating the error beforehand")
    stated = stated_error(best.hypothesis, best.found.z, tau, unseen, (empty, nothing.found.z))
    motion = OutputError(best.hypothesis).motion(best.found.z)
    others = sorted((f for f in tried if f is not best), key=lambda f: -f.log_odds)
    found = Found(
        explanation(nothing), explanation(best), tuple(explanation(f) for f in others),
        tuple(screened), motion,
    )  # fmt: skip
    return Searched(found, stated)


def calibrated_model(problem: Problem) -> LinearModel:
    """Return the twin without laws whose simulation comes nearest to the recordings."""
    empty = Hypothesis(problem)
    z = _calibrated(empty, np.zeros(len(empty.unknowns))).found.z
    return problem.base(z[: len(problem.base_unknowns)])


def loosened(nothing: Explanation, tolerance: float) -> Explanation:
    """Return the calibrated twin with its masses, stiffnesses and dampings freed.

    Args:
        nothing: the same within its tolerances.
        tolerance: instead of them.
    """
    own = nothing.hypothesis.problem
    if min(own.tolerance, own.damping_tolerance) >= tolerance:
        return nothing
    free = Hypothesis(replace(own, tolerance=tolerance, damping_tolerance=tolerance))
    z = np.zeros(len(free.unknowns))
    tau = independent_share(OutputError(free).residuals(nothing.fit.z))
    found = _climbed(OutputError(free, tau), z)
    return explanation(Fitted(free, found, found.log_evidence, tau))


def _calibrated(empty: Hypothesis, begin: Array) -> Fitted:
    """Return the twin without laws, fitted with the samples that count for its own rest."""
    first = _climbed(OutputError(empty), begin)
    tau = independent_share(OutputError(empty).residuals(first.z))
    first = _climbed(OutputError(empty, tau), begin)
    return Fitted(empty, first, first.log_evidence, tau)


def _climbed(model: OutputError, z: Array) -> Simulated:
    found = climb(model, z, STEPS)
    if found is None:
        raise ModelError("the twin as it stands has no finite simulation of the recordings")
    return found


def _screened(model: OutputError, found: Simulated, candidates: Sequence[Candidate]) -> list[Score]:
    """Return the best first guess of every candidate by the score test (Rao 1948)."""
    here, z = model.hypothesis, found.z
    r = np.vstack(model.residuals(z))
    root = np.linalg.inv(np.linalg.cholesky(model.covariance(r)))
    scale = np.sqrt(model.tau)
    J = model.slopes(z, r, model.free)
    white = scale * (r @ root.T).ravel()
    slopes = scale * np.einsum("ij,njp->nip", root, J).reshape(len(white), -1)
    q, _ = np.linalg.qr(np.vstack([slopes, np.eye(slopes.shape[1])]))
    basis, prior = q[: len(white)], q[len(white) :]
    told = basis.T @ white + prior.T @ z[model.free]
    best = {c.label: Score(c, c.starts[0], 0.0) for c in candidates}
    for candidate in candidates:
        for start in candidate.starts:
            grown = added(here, candidate, start)
            weak = start.scaled(SMALL)
            point = moved_to(grown, here, z, weak)
            try:
                changed = np.vstack(OutputError(grown).residuals(point))
            except (ValueError, np.linalg.LinAlgError):
                continue
            if not np.all(np.isfinite(changed)):
                continue
            d = scale * ((changed - r) @ root.T).ravel() / SMALL
            across = basis.T @ d
            s = float(d @ white - across @ told)
            information = max(float(d @ d - across @ across), 1e-9 * float(d @ d), 1e-300)
            strength = -s / information
            if strength <= 0:
                continue
            # a slope tells nothing of what is far stronger than the motion it was guessed from
            inside = min(strength, STRENGTHS[1])
            gain = -s * inside - 0.5 * information * inside**2
            if gain > best[candidate.label].gain:
                begun = start.scaled(max(inside, STRENGTHS[0]))
                best[candidate.label] = Score(candidate, begun, gain)
    return sorted(best.values(), key=lambda score: -score.gain)


def explanation(fitted: Fitted) -> Explanation:
    """Return the same as any search has it, with the noise that its residuals are.

    The discrepancy of each law is the share of its force that the residuals are of the outputs.
    """
    hypothesis, found = fitted.hypothesis, fitted.found
    model, problem = OutputError(hypothesis), hypothesis.problem
    z = found.z.copy()
    pieces = model.residuals(z)
    error = np.sqrt(sum(float(np.sum(p**2)) for p in pieces)
                    / sum(float(np.nansum(r.y**2)) for r in problem.recordings))  # fmt: skip
    forces = model.law_forces(z)
    level = dict[str, float]()
    for t, piece in enumerate(pieces):
        name = problem.recordings[t].name
        rms = np.sqrt(np.mean(piece**2, axis=0))
        level |= {
            f"noise of {o} in {name}": v for o, v in zip(problem.model.outputs, rms, strict=True)
        }
    for law, force in zip(hypothesis.laws, forces, strict=True):
        level[f"discrepancy {law.place}"] = error * force
    for i, unknown in enumerate(hypothesis.unknowns):
        if unknown.name in level:
            value = np.log(max(level[unknown.name], 1e-300))
            z[i] = (value - unknown.mean) / unknown.deviation
        elif unknown.name.startswith("process noise"):
            z[i] = QUIET
    covariance = np.eye(len(z))
    covariance[np.ix_(model.free, model.free)] = found.covariance
    fit = Fit(
        hypothesis, z, covariance, found.log_posterior, found.log_posterior, found.log_evidence,
        "converged", STEPS,
    )  # fmt: skip
    return Explanation(hypothesis, fit, fitted.log_odds)
