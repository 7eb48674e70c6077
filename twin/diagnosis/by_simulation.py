"""The search where the ground alone shakes a structure whose numbers are not known.

A motion that is strong throughout has no gentle part on which a linear twin could be calibrated,
and a predictor that listens to the outputs lets process noise stand for what the twin lacks. Here
every hypothesis is judged by its simulation (``simulation``): laws are added at ports while one
pays for itself, by a score test of every law at every port, a fit of the most promising, and
evidence by Laplace's method, at the price that any law at any place is as likely as another.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import added, moved_to
from twin.diagnosis.candidates import Candidate, scales_of
from twin.diagnosis.detection import NO_PROCESS_NOISE
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.large_motion import ENOUGH
from twin.diagnosis.predict import placed
from twin.diagnosis.problem import Problem
from twin.diagnosis.scales import TINY
from twin.diagnosis.score_test import Profiled
from twin.diagnosis.search import Found, Offer
from twin.diagnosis.simulation import OutputError, independent_share
from twin.diagnosis.stated import stated_error
from twin.diagnosis.valleys import WIDTH, Score, first_of_each
from twin.errors import ModelError
from twin.estimation.fit import Fit
from twin.mechanisms.mechanism import Law
from twin.model.linear import LinearModel

Array = NDArray[np.float64]

MOST = 2
"""Laws at most: a simulation of strong motion tells no third one from what the first two lack."""

STRENGTHS = (0.1, 10.0)
"""Strengths in first guesses between which a fit begins; a law's direction is taken at the lower
one, for what slips has none at zero."""

GRID = 201
"""Drifts at which it is asked whether a structure stands: half a per cent of its motion apart."""


def search_by_simulation(
    problem: Problem, unseen: Problem, offer: Offer,
    tell: Callable[[str], None] = lambda message: None,
) -> Found:  # fmt: skip
    """Find the laws whose simulations explain the recordings, and state the error beforehand.

    Args:
        problem: the estimation problem.
        unseen: recordings of which the error is stated; their outputs are not used.
        offer: returns all candidates, given the motion of each recording.
        tell: is told each step.
    """
    empty = Hypothesis(problem)
    first, tau = _counted(empty)
    nothing = best = Explanation(empty, first, first.log_evidence)
    tried: list[Explanation] = []
    screened = []
    for step in range(MOST):
        tell(f"search step {step + 1}: screening")
        moved = OutputError(best.hypothesis).motion(best.fit.z)
        here = replace(best.hypothesis, scales=scales_of(problem, moved))
        candidates = [c for c in offer(moved, ()) if isinstance(c.starts[0], Law)
                      and c.label not in best.labels]  # fmt: skip
        cost = float(np.log(max(len(candidates), 2)))
        scores = _screened(OutputError(here, tau), best.fit.z, candidates)
        screened.append(tuple(scores))
        fits = list[Explanation]()
        ahead = [s for s in scores if s.gain > cost]
        kinds = first_of_each([s.candidate.label[0] for s in ahead])
        for number, score in enumerate(ahead[i] for i in kinds[:WIDTH]):
            what = " at ".join(score.candidate.label)
            tell(f"search step {step + 1}: fitting {what} ({number + 1})")
            grown = added(here, score.candidate, score.start)
            z = moved_to(grown, here, best.fit.z, score.start)
            try:
                likeliest = max((e.fit.log_evidence for e in fits), default=-np.inf)
                found = OutputError(grown, tau).fitted(z, hopeless=likeliest)
            except np.linalg.LinAlgError:
                continue
            if not stands(grown, found.z, unseen):
                continue
            odds = found.log_evidence - cost * len(grown.mechanisms)
            fits.append(Explanation(grown, found, odds))
        tried += fits
        top = max(fits, key=lambda e: e.log_odds, default=best)
        if top.log_odds <= best.log_odds + ENOUGH:
            break
        best = top
    tell("stating the error beforehand")
    stated = stated_error(best.hypothesis, best.fit.z, tau, unseen, (empty, nothing.fit.z))
    motion = OutputError(best.hypothesis).motion(best.fit.z)
    others = sorted((e for e in tried if e is not best), key=lambda e: -e.log_odds)
    return Found(
        with_noise(nothing), with_noise(best), tuple(with_noise(e) for e in others),
        tuple(screened), motion, stated,
    )  # fmt: skip


def stands(hypothesis: Hypothesis, z: Array, unseen: Problem) -> bool:
    """Return whether at every law's port the force at rest grows with the drift, as far as it goes.

    A structure whose tangent stiffness is negative there would have fallen off, not come back, in
    motions that were recorded. What softens within the motion seen may not do so beyond it.

    Args:
        hypothesis: the twin with its laws.
        z: values of its unknowns, (p,).
        unseen: other recordings, of which only the inputs are used.
    """
    there, own = placed(hypothesis, z, unseen)
    moved = (*OutputError(hypothesis).motion(z), *OutputError(there).motion(own))
    compliance = np.linalg.pinv(hypothesis.problem.base(z).K)
    laws = [m for m in hypothesis.at(z) if isinstance(m, Law)]
    for port in {law.place for law in laws}:
        row = hypothesis.problem.model.port(port)
        drifts = np.concatenate([m.q @ row for m in moved])
        if not np.all(np.isfinite(drifts)):
            return False
        d = np.linspace(drifts.min(), drifts.max(), GRID)
        rest = np.zeros_like(d)
        force = d / max(float(row @ compliance @ row), TINY)
        for law in laws:
            if law.place == port:
                force = force + law.force(d, rest, rest, 0.0)
        if np.any(np.diff(force) < 0):
            return False
    return True


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
    tau = independent_share(OutputError(nothing.hypothesis).residuals(nothing.fit.z))
    found = _calibrated(OutputError(free, tau), z)
    return with_noise(Explanation(free, found, found.log_evidence))


def calibrated_model(problem: Problem) -> LinearModel:
    """Return the twin without laws whose simulation comes nearest to the recordings."""
    found, _ = _counted(Hypothesis(problem))
    return problem.base(found.z[: len(problem.base_unknowns)])


def _counted(empty: Hypothesis) -> tuple[Fit, float]:
    """Return the twin without laws, fitted, and the share of the samples that count for it."""
    begin = np.zeros(len(empty.unknowns))
    first = _calibrated(OutputError(empty), begin)
    tau = independent_share(OutputError(empty).residuals(first.z))
    return _calibrated(OutputError(empty, tau), begin), tau


def _calibrated(model: OutputError, z: Array) -> Fit:
    """Return a fit from z, (p,)."""
    try:
        return model.fitted(z)
    except np.linalg.LinAlgError:
        raise ModelError(
            "the twin as it stands has no finite simulation of the recordings"
        ) from None


def _screened(model: OutputError, z: Array, candidates: Sequence[Candidate]) -> list[Score]:
    """Return the best first guess of every candidate by the score test (Rao 1948)."""
    here = model.hypothesis
    runs = model.runs(z, model.free)
    r = np.vstack([run.e for run in runs])
    white, slopes = model.whitened(runs)
    profiled = Profiled([slopes[:, model.free]], [white], z[model.free])
    best = {c.label: Score(c, c.starts[0], 0.0) for c in candidates}
    for candidate in candidates:
        for start in candidate.starts:
            grown = added(here, candidate, start)
            weak = start.scaled(STRENGTHS[0])
            point = moved_to(grown, here, z, weak)
            try:
                changed = np.vstack(OutputError(grown).residuals(point))
            except np.linalg.LinAlgError:
                continue
            if not np.all(np.isfinite(changed)):
                continue
            direction = model.whiten((changed - r)[:, :, None] / STRENGTHS[0], r)
            (gain,), (strength,), _ = profiled.gains([direction])
            if strength <= 0:
                continue
            # a slope tells nothing of what is far stronger than the motion it was guessed from
            inside = min(strength, STRENGTHS[1])
            gain *= inside / strength * (2 - inside / strength)
            if gain > best[candidate.label].gain:
                begun = start.scaled(max(inside, STRENGTHS[0]))
                best[candidate.label] = Score(candidate, begun, gain)
    return sorted(best.values(), key=lambda score: -score.gain)


def with_noise(explanation: Explanation) -> Explanation:
    """Return the same with the noise that its residuals are, and no process noise.

    The discrepancy of each law is the share of its force that the residuals are of the outputs.
    """
    hypothesis = explanation.hypothesis
    model, problem = OutputError(hypothesis), hypothesis.problem
    z = explanation.fit.z.copy()
    pieces = model.residuals(z)
    error = np.sqrt(sum(float(np.sum(p**2)) for p in pieces)
                    / sum(float(np.nansum(r.y**2)) for r in problem.recordings))  # fmt: skip
    level = dict[str, float]()
    for recording, piece in zip(problem.recordings, pieces, strict=True):
        rms = np.sqrt(np.mean(piece**2, axis=0))
        for output, value in zip(problem.model.outputs, rms, strict=True):
            level[f"noise of {output} in {recording.name}"] = value
    for law, force in zip(hypothesis.laws, model.law_forces(z), strict=True):
        name = f"discrepancy {hypothesis.port_of(law.place)}"
        if hypothesis.port_of(law.place) in hypothesis.erring:
            level[f"{name} share"] = error
        else:
            level[name] = max(level.get(name, 0.0), error * force)
    for i, unknown in enumerate(hypothesis.unknowns):
        if unknown.name in level:
            value = np.log(max(level[unknown.name], 1e-300))
            z[i] = (value - unknown.mean) / unknown.deviation
        elif unknown.name.startswith("process noise"):
            z[i] = NO_PROCESS_NOISE
    return replace(explanation, fit=replace(explanation.fit, z=z))
