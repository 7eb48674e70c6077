"""Screen every mechanism at every place: what each would explain, before any is fitted in full.

Along the smoothed motion the force of a law is known but for its strength, and a known force
enters the innovations of a linear filter linearly: so a regression says how much of them it
explains. What is linear is fitted at once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin import physics
from twin.diagnosis.base import surroundings
from twin.diagnosis.bench import Bench
from twin.diagnosis.filtering import effect_of_force
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.fitting import (
    STEP,
    Fit,
    covariances,
    fit,
    gains_of,
    log_likelihood,
    with_disturbances,
)
from twin.diagnosis.motion import at_place, force_histories
from twin.diagnosis.plant import build, place_vector, sampled
from twin.physics.mechanism import ChannelFault, Disturbance, Law, Mechanism

Array = NDArray[np.float64]

PEAKS = 3


@dataclass(frozen=True)
class Candidate:
    """A mechanism at a place with first values, and the log likelihood that it promises to gain.

    Attributes:
        mechanism: with first values.
        gain: of the log likelihood.
        hypothesis: that of the scene with all parameters as they would move along.
    """

    mechanism: Mechanism
    gain: float
    hypothesis: Hypothesis | None = None

    @property
    def label(self) -> tuple[str, str]:
        """Mechanism and place."""
        return self.mechanism.name, self.mechanism.place


@dataclass(frozen=True)
class Scene:
    """What the screening starts from.

    Attributes:
        bench: with the forces of found laws as inputs.
        fit: of what was found before, on that bench.
        moved: smoothed states of every trial, (samples, n).
        heights: of the storeys [m].
    """

    bench: Bench
    fit: Fit
    moved: tuple[Array, ...]
    heights: Mapping[str, float]

    def peaks(self) -> tuple[float, ...]:
        """Return the frequencies at which the innovations stand out most [Hz]."""
        try:
            gains = gains_of(self.bench, self.fit.hypothesis, 1e-4)
        except np.linalg.LinAlgError:
            gains = self.fit.gains
        rows = self.bench.innovations([self.fit.hypothesis], gains, self.fit.starts)
        density, f = None, None
        for row, S in zip(rows, covariances([r[0] for r in rows]), strict=True):
            e = row[0] / np.sqrt(np.diag(S))
            f, each = signal.welch(e, 1 / self.bench.step_s, nperseg=min(2048, len(e)), axis=0)
            density = each.sum(axis=1) + (0 if density is None else density)
        assert density is not None
        tops, _ = signal.find_peaks(density)
        tops = tops[np.argsort(-density[tops])][:PEAKS]
        return tuple(float(f[i]) for i in tops if f[i] > 0)

    def motion(self) -> dict[str, Array]:
        """Return the pooled motion: "storey1", "rate storey1", "floor1", ... -> (samples,)."""
        model = self.bench.model
        floors = [c for c in model.coordinates if c.startswith("floor")]
        places = [c.replace("floor", "storey") for c in floors] + list(model.coordinates)
        out = {}
        for place in places:
            pairs = [at_place(model, state, place) for state in self.moved]
            out[place] = np.concatenate([d for d, _ in pairs])
            out[f"rate {place}"] = np.concatenate([v for _, v in pairs])
        return out


def screen(scene: Scene, without: Sequence[tuple[str, str]] = ()) -> list[Candidate]:
    """Return the best first values of every mechanism at every place, the most promising first."""
    bench = scene.bench
    motion = scene.motion()
    peaks = scene.peaks()
    regression = _Regression(scene)
    out = []
    floors = [c for c in bench.model.coordinates if c.startswith("floor")]
    channels = [*bench.trials[0].outputs, *bench.trials[0].inputs]
    channels = [c for c in channels if not c.startswith("law_")]
    for name, cls in physics.mechanisms().items():
        for place in physics.places(cls, floors, channels):
            if (name, place) in without or not _possible(cls, place, bench):
                continue
            starts = cls.starts(place, surroundings(bench, motion, scene.heights, place, peaks))
            if not starts:
                continue
            if issubclass(cls, Law):
                out.append(regression.best(starts))
            else:
                out.append(_fitted(scene, starts))
    return sorted((c for c in out if np.isfinite(c.gain)), key=lambda c: -c.gain)


def _possible(cls: type[Mechanism], place: str, bench: Bench) -> bool:
    """Return whether the model and the recordings have what the mechanism needs."""
    if cls.where in ("channel", "channels"):
        return True
    if cls.where == "pendulum":
        return "pendulum" in bench.model.coordinates
    if cls.generic:
        return False
    return not (cls.name == "base_compliance" and "ground" in bench.model.coordinates)


def _fitted(scene: Scene, starts: Sequence[Mechanism]) -> Candidate:
    """Fit a linear mechanism from the best of its starts, in a few steps."""
    bench, fit0 = scene.bench, scene.fit
    if isinstance(starts[0], ChannelFault) and starts[0].limit() is not None:
        return _clipped(scene, starts)
    best, value = None, -np.inf
    for start in starts:
        hypothesis = fit0.hypothesis.including(start)
        try:
            gains = gains_of(bench, hypothesis, fit0.slack)
            begin = [_grown(s, g) for s, g in zip(fit0.starts, gains, strict=True)]
            rows = bench.innovations([hypothesis], gains, begin)
        except np.linalg.LinAlgError:
            continue
        found = log_likelihood([row[0] for row in rows])
        if found > value:
            best, value = start, found
    if best is None:
        return Candidate(starts[0], -np.inf)
    hypothesis = fit0.hypothesis.including(best)
    if not best.parameters:
        return Candidate(best, value - fit0.log_likelihood)
    try:
        found_fit = fit(bench, hypothesis, fit0.slack, fit0.starts, iterations=3)
    except np.linalg.LinAlgError:
        return Candidate(best, value - fit0.log_likelihood)
    if isinstance(best, Disturbance):
        found_fit = with_disturbances(bench, found_fit)
    gained = found_fit.log_posterior - fit0.log_posterior
    rest = replace(found_fit.hypothesis, found=found_fit.hypothesis.found[:-1])
    return Candidate(found_fit.hypothesis.found[-1], gained, rest)


def _clipped(scene: Scene, starts: Sequence[Mechanism]) -> Candidate:
    """Return the level that explains most when predictions beyond it are cut off there."""
    bench, fit0 = scene.bench, scene.fit
    best = Candidate(starts[0], -np.inf)
    for start in starts:
        assert isinstance(start, ChannelFault)
        level = start.limit()
        row = bench.trials[0].outputs.index(start.place)
        cut = []
        for trial, e in zip(bench.trials, fit0.innovations, strict=True):
            predicted = trial.y[:, row] - e[:, row]
            changed = e.copy()
            changed[:, row] = trial.y[:, row] - np.clip(predicted, -level, level)
            cut.append(changed)
        gained = log_likelihood(cut) - fit0.log_likelihood
        if gained > best.gain:
            best = Candidate(start, gained)
    return best


def _grown(start: Array, gains) -> Array:  # noqa: ANN001
    n = len(gains.filtered)
    return np.concatenate([start, np.zeros(n)])[:n]


class _Regression:
    """The innovations of the scene's fit, whitened, without what its own parameters explain."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        bench, fit0 = scene.bench, scene.fit
        unknowns = fit0.hypothesis.unknowns()
        theta = fit0.hypothesis.vector(unknowns)
        size = np.array([u.size for u in unknowns])
        variants = [fit0.hypothesis.at(unknowns, theta + step) for step in np.diag(STEP * size)]
        rows = bench.innovations(variants, fit0.gains, fit0.starts)
        Phi = bench.start_effects(fit0.hypothesis, fit0.gains)
        self.W = [np.linalg.inv(np.linalg.cholesky(S)).T for S in covariances(fit0.innovations)]
        J, e = [], []
        for i, own in enumerate(fit0.innovations):
            d = (rows[i] - own[None]) / (STEP * size)[:, None, None] * size[:, None, None]
            J.append(self.whitened(i, d))
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
        self.plants: dict[str, list] = {}

    def whitened(self, trial: int, effects: Array) -> Array:
        """Return effects (p, samples, m) as columns of whitened samples, (samples m, p)."""
        return np.moveaxis(effects @ self.W[trial], 0, -1).reshape(-1, len(effects))

    def best(self, starts: Sequence[Mechanism]) -> Candidate:
        """Return the start that explains most, at its best strength."""
        scene = self.scene
        bench, fit0 = scene.bench, scene.fit
        law = starts[0]
        parts = []
        motions = [at_place(bench.model, state, law.place) for state in scene.moved]
        histories = force_histories(starts, motions, bench.step_s)
        for i, trial in enumerate(bench.trials):
            found = fit0.hypothesis.including(law).mechanisms
            whole = build(trial.base(bench.model), found, trial.inputs, trial.outputs)
            plant = sampled(whole, bench.step_s, bench.between == "held")
            effects = [effect_of_force(plant, fit0.gains[i], 0, f) for f in histories[i]]
            parts.append(self.whitened(i, np.array(effects)))
        X = np.vstack([*parts, np.zeros((len(self.unknowns), len(starts)))])
        raw = X
        X = X - self.Q @ (self.Q.T @ X)
        power = np.sum(X**2, axis=0)
        power[power == 0] = np.inf
        inner = X.T @ self.rest
        # e - (-X) a: the effect of strength a is a X, so the best a is -inner / power
        strength = -inner / power
        explained = inner**2 / power
        if (law.parameters[next(iter(law.parameters))]).scale == "log":
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


def locate(
    scene: Scene, levels: Sequence[float] = (1e-3, 3e-3, 1e-2, 3e-2, 0.1)
) -> dict[str, float]:
    """Return for every place how much a latent force there raises the log likelihood.

    White force noise enters at one place at a time (a storey: a pair), at its best level.
    """
    bench, fit0 = scene.bench, scene.fit
    model = bench.model
    floors = [c for c in model.coordinates if c.startswith("floor")]
    places = [c.replace("floor", "storey") for c in floors] + list(model.coordinates)
    plants = [row[0] for row in bench._plants([fit0.hypothesis])]
    out = {}
    reference = None
    for place in [None, *places]:
        values = []
        for level in levels if place else (0.0,):
            gains = []
            try:
                for trial, plant in zip(bench.trials, plants, strict=True):
                    scale = float(np.max(bench.force_scale(trial, plant)))
                    inner = plant.plant.model
                    latent = level * scale * place_vector(inner, place) if place else None
                    gains.append(bench.gain(trial, plant, 1e-5, latent))
            except np.linalg.LinAlgError:
                values.append(-np.inf)
                continue
            rows = bench.innovations([fit0.hypothesis], gains, fit0.starts)
            values.append(log_likelihood([row[0] for row in rows]))
        if place is None:
            reference = values[0]
        else:
            gained = max(values) - float(reference or 0.0)
            out[place] = gained if np.isfinite(gained) else 0.0
    return out
