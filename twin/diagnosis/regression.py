"""How much of the innovations a law explains, by regression along the smoothed motion.

Along the smoothed motion the force of a law is known but for its strength, and a known force
enters the innovations of a linear filter linearly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.base import level
from twin.diagnosis.bench import Bench
from twin.diagnosis.effects import effects_of_forces
from twin.diagnosis.filtering import Gain
from twin.diagnosis.fitting import STEP, Slopes, covariances, lenient_gains
from twin.diagnosis.hypothesis import Hypothesis, Unknown
from twin.diagnosis.motion import at_place, force_histories
from twin.diagnosis.plant import build, sampled
from twin.diagnosis.scene import Candidate, Scene
from twin.mechanisms.mechanism import Law, Mechanism
from twin.mechanisms.quadratic_drag import QuadraticDrag
from twin.mechanisms.slight import SlightChange

Array = NDArray[np.float64]

STRAIGHT = 3e-3
"""Slack, at least, with which a base that was bent is followed as the model has it."""


class Regression:
    """The innovations of the scene's fit, whitened, without what its own parameters explain."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        bench, fit0 = scene.bench, scene.fit
        unknowns = fit0.hypothesis.unknowns()
        theta = fit0.hypothesis.vector(unknowns)
        size = np.array([u.size for u in unknowns])
        slopes = _slopes(bench, fit0.hypothesis, fit0.gains, fit0.starts)
        Phi = bench.start_effects(fit0.hypothesis, fit0.gains)
        self.W = [np.linalg.inv(np.linalg.cholesky(S)).T for S in covariances(fit0.innovations)]
        J, e = [], []
        for i, own in enumerate(fit0.innovations):
            J.append(self.whitened(i, slopes[i] * size[:, None, None]))
            e.append((own @ self.W[i]).reshape(-1, 1))
        prior = np.diag([0.0 if np.isinf(u.prior_std) else u.size / u.prior_std for u in unknowns])
        mean = np.array([u.prior_mean for u in unknowns])
        pull = (
            -(theta - mean) / size * np.diag(prior)
        )  # the prior's residual is prior (theta + step) / size
        self.lengths = [len(x) for x in e]
        blocks = [np.vstack([*J, prior])]
        starts = []
        offset = 0
        total = sum(self.lengths) + len(unknowns)
        for i, phi in enumerate(Phi):
            block = np.zeros((total, phi.shape[0]))
            block[offset : offset + self.lengths[i]] = self.whitened(i, phi)
            norm = np.linalg.norm(block, axis=0)
            starts.append(block[:, norm > 0] / norm[norm > 0])
            offset += self.lengths[i]
        self.Q, self.R = np.linalg.qr(np.hstack([*blocks, *starts]))
        self.target = np.concatenate([np.vstack(e)[:, 0], -pull])
        self.rest = self.target - self.Q @ (self.Q.T @ self.target)
        self.unknowns, self.theta, self.size = unknowns, theta, size
        self.slopes = _by_unknown(unknowns, slopes)

    @cached_property
    def straight(self) -> tuple[Scene, float, Slopes]:
        """The scene with its base as the model has it, the slack to follow it with, the slopes."""
        bench, fit0 = self.scene.bench, self.scene.fit
        hypothesis, slack = level(fit0.hypothesis), max(fit0.slack, STRAIGHT)
        scene = replace(self.scene, fit=replace(fit0, hypothesis=hypothesis))
        gains = lenient_gains(bench, hypothesis, slack)
        slopes = _slopes(bench, hypothesis, gains, fit0.starts)
        return scene, slack, _by_unknown(hypothesis.unknowns(), slopes)

    def whitened(self, trial: int, effects: Array) -> Array:
        """Return effects (p, samples, m) as columns of whitened samples, (samples m, p)."""
        return np.moveaxis(effects @ self.W[trial], 0, -1).reshape(-1, len(effects))

    def best(self, starts: Sequence[Law]) -> Candidate:
        """Return the start that explains most, at its best strength."""
        scene = self.scene
        motions = [at_place(scene.bench.model, state, starts[0].place) for state in scene.moved]
        return self._strongest(starts, force_histories(starts, motions, scene.bench.step_s))

    def slight(self, starts: Sequence[SlightChange]) -> Candidate:
        """Return the slight change that explains most, at the strength it would have."""
        scene = self.scene
        step_s = scene.bench.step_s
        histories = []
        for state in scene.moved:
            _, rate = at_place(scene.bench.model, state, starts[0].place)
            histories.append(np.array([start.reaction(rate, step_s) for start in starts]))
        return self._strongest(starts, histories)

    def _strongest(self, starts: Sequence[Mechanism], histories: Sequence[Array]) -> Candidate:
        """Regress on the effects of force histories, one (starts, samples) a trial."""
        scene = self.scene
        bench, fit0 = scene.bench, scene.fit
        first = starts[0]
        entry = first if isinstance(first, Law) else QuadraticDrag(first.place)
        parts = []
        for i, trial in enumerate(bench.trials):
            found = fit0.hypothesis.including(entry).mechanisms
            whole = build(trial.base(bench.model), found, trial.inputs, trial.outputs)
            plant = sampled(whole, bench.step_s, bench.held)
            effects = effects_of_forces(plant, fit0.gains[i], 0, histories[i])
            parts.append(self.whitened(i, effects))
        X = np.vstack([*parts, np.zeros((len(self.unknowns), len(starts)))])
        raw = X
        X = X - self.Q @ (self.Q.T @ X)
        power = np.sum(X**2, axis=0)
        power[power == 0] = np.inf
        inner = X.T @ self.rest
        # e - (-X) a: the effect of strength a is a X, so the best a is -inner / power
        strength = -inner / power
        explained = inner**2 / power
        if (first.parameters[next(iter(first.parameters))]).scale == "log":
            explained = np.where(strength > 0, explained, 0.0)
        winner = int(np.argmax(explained))
        if explained[winner] <= 0:
            return Candidate(starts[winner], -np.inf)
        total = float(self.rest @ self.rest)
        share = min(explained[winner] / total, 1 - 1e-12)
        gained = -0.5 * total * np.log1p(-share)
        moved = self.target + strength[winner] * raw[:, winner]
        step = -np.linalg.lstsq(self.R, self.Q.T @ moved, rcond=1e-12)[0][: len(self.unknowns)]
        along = fit0.hypothesis.at(self.unknowns, self.theta + np.clip(step, -20, 20) * self.size)
        return Candidate(starts[winner].scaled(float(strength[winner])), float(gained), along)


def _slopes(
    bench: Bench, hypothesis: Hypothesis, gains: Sequence[Gain], starts: Sequence[Array]
) -> list[Array]:
    """Return the derivatives of the innovations, one (unknowns, samples, m) a trial."""
    unknowns = hypothesis.unknowns()
    steps = STEP * np.array([u.size for u in unknowns])
    moved = hypothesis.vector(unknowns) + np.vstack([np.zeros(len(unknowns)), np.diag(steps)])
    rows = bench.innovations([hypothesis.at(unknowns, v) for v in moved], gains, starts)
    return [(its[1:] - its[0]) / steps[:, None, None] for its in rows]


def _by_unknown(unknowns: Sequence[Unknown], slopes: Sequence[Array]) -> Slopes:
    return {(u.index, u.name): [d[c] for d in slopes] for c, u in enumerate(unknowns)}
