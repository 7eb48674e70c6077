"""The bench: trials and model together, and the innovations of any hypothesis on them."""

from __future__ import annotations

import math
import multiprocessing
import os
from collections.abc import Hashable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.channels import as_recorded, changes_data, corrected, limits_of
from twin.diagnosis.effects import effect_of_start
from twin.diagnosis.filtering import (
    Gain,
    gain,
    innovations_of,
    side_by_side,
    with_laws,
)
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.plant import Sampled, build, laws_of, sampled
from twin.diagnosis.trials import MOTOR, Trial
from twin.mechanisms.mechanism import ChannelFault, Law, Mechanism
from twin.second_order import SecondOrderModel

Array = NDArray[np.float64]
Between = Literal["band_limited", "linear", "held"]

SLACKS = (1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3)
"""Force noise that a filter may assume beyond the measured one, as a share of inertia forces."""

STEPS, ABRUPT_STEPS = 2, 4
"""Integration steps a sample for laws that are smooth, and for those with corners."""

PER_PERIOD, ABRUPT_PER_PERIOD = 20, 50
"""The same in a period of the fastest mode."""

FAST = 0.25
"""Periods a sample beyond which a mode asks for no shorter steps: it is far stiffer than what the
laws do to it, its own motion is exact at any length, and what little it does is filtered out."""

KEPT = 200
"""Sampled plants that are kept: gains and innovations of a hypothesis ask for the same ones."""

LEAST_NOISE = 1e-4
"""Smallest noise of a channel as a share of its RMS: below it the filter has nothing to weigh."""


@dataclass(frozen=True)
class Bench:
    """What is known before any hypothesis.

    Attributes:
        model: M, R, K of the twin as it is.
        trials: recordings of one sampling rate with the same channels.
        between: what the inputs do between samples.
        ground_mass: of the model's ground [kg], or NaN.
        slacks: force noise that a filter may assume beyond the measured one, as a share of the
            inertia forces, smallest first.
    """

    model: SecondOrderModel
    trials: tuple[Trial, ...]
    between: Between = "band_limited"
    ground_mass: float = float("nan")
    slacks: tuple[float, ...] = SLACKS

    @property
    def step_s(self) -> float:
        """Sampling interval [s]."""
        return 1 / self.trials[0].sampling_hz

    @property
    def held(self) -> NDArray[np.bool_]:
        """Which inputs are held from sample to sample, (r,)."""
        names = self.trials[0].inputs
        return np.array([self.between == "held" or n.startswith(MOTOR) for n in names], bool)

    @property
    def samples(self) -> int:
        """Samples of all trials."""
        return sum(trial.samples for trial in self.trials)

    def force_scale(self, trial: Trial, plant: Sampled) -> Array:
        """Return the RMS of inertia forces on the coordinates [N], a scale for force noise."""
        acc = [
            float(np.sqrt(np.mean(trial.y[:, i] ** 2)))
            for i, name in enumerate(trial.outputs)
            if name.startswith("acc")
        ]
        mass = np.diag(plant.plant.model.M)
        if acc:
            return mass * max(acc)
        disp = float(np.sqrt(np.mean(trial.y**2)))
        return np.diag(plant.plant.model.K) * disp

    def plant(self, trial: Trial, mechanisms: Sequence[Mechanism], steps: int = 1) -> Sampled:
        """Return the sampled plant of a hypothesis for a trial."""
        whole = build(trial.base(self.model), mechanisms, trial.inputs, trial.outputs)
        return sampled(whole, self.step_s / steps, held=self.held)

    def _plants(self, variants: Sequence[Hypothesis], steps: int = 1) -> list[list[Sampled]]:
        """Return plants[trial][variant]; recordings with the same masses share them."""
        kept, out = self._sampled, []
        if len(kept) > KEPT:
            kept.clear()
        for trial in self.trials:
            masses = tuple(sorted(trial.added_mass.items()))
            row = []
            for variant in variants:
                key = (masses, steps, variant.mechanisms)
                if key not in kept:
                    kept[key] = self.plant(trial, variant.mechanisms, steps)
                row.append(kept[key])
            out.append(row)
        return out

    @cached_property
    def _sampled(self) -> dict[Hashable, Sampled]:
        return {}

    def gain(self, trial: Trial, plant: Sampled, slack: float, latent: Array | None = None) -> Gain:
        """Return the stationary gain.

        Args:
            trial: for its noise levels.
            plant: of the hypothesis.
            slack: white force noise on every coordinate as a share of the inertia forces; it lets
                the filter follow data that its model does not explain.
            latent: one more white force, its entry at the coordinates [N], (places,).
        """
        floor = LEAST_NOISE * np.sqrt(np.mean(trial.y**2, axis=0)) + 1e-12
        noise = np.diag(max(slack, 1e-5) * self.force_scale(trial, plant))
        if latent is not None:
            noise = np.column_stack([noise, latent])
        return gain(
            plant,
            trial.input_noise,
            np.maximum(trial.output_noise, floor),
            noise,
        )

    def smooth(self, u: Array) -> Array:
        """Return the inputs (samples, r) as they drive the states between the samples.

        Straight lines between samples lose sinc^2 of a band-limited signal; to fourth order in the
        frequency that is put back first.
        """
        if self.between != "band_limited" or len(u) < 5:
            return u
        second = np.zeros_like(u)
        second[1:-1] = np.diff(u, 2, axis=0)
        fourth = np.zeros_like(u)
        fourth[2:-2] = np.diff(u, 4, axis=0)
        return u - np.where(self.held, 0.0, second / 12 - fourth / 90)

    def innovations(
        self,
        variants: Sequence[Hypothesis],
        gains: Sequence[Gain],
        starts: Sequence[Array] | None = None,
    ) -> list[Array]:
        """Return the innovations of hypotheses with the same mechanisms, other values.

        Args:
            variants: the hypotheses.
            gains: one a trial, used for all variants.
            starts: initial states (n,) of each trial, or rest.

        Returns:
            One (variants, samples, m) a trial.
        """
        mechanisms = variants[0].mechanisms
        laws = laws_of(mechanisms)
        if laws or np.isfinite(limits_of(mechanisms, self.trials[0].outputs)).any():
            return self._stepped(variants, gains, starts)
        plants = self._plants(variants)
        # variants with the same faults share their corrected channels
        alike: dict[tuple[ChannelFault, ...], list[int]] = {}
        for position, variant in enumerate(variants):
            its = tuple(m for m in variant.mechanisms if isinstance(m, ChannelFault))
            alike.setdefault(its, []).append(position)
        out = []
        for number, trial in enumerate(self.trials):
            rows = np.empty((len(variants), trial.samples, len(trial.outputs)))
            begin = None if starts is None else starts[number]
            for faults, positions in alike.items():
                sound = corrected(trial, faults)
                given = self._given[number] if sound is trial else self._side_by_side(sound)
                chosen = [plants[number][position] for position in positions]
                found = innovations_of(chosen, gains[number], given, sound.y, begin)
                rows[positions] = found * as_recorded(trial, faults)
            out.append(rows)
        return out

    def _side_by_side(self, trial: Trial) -> Array:
        return side_by_side(trial.u, self.smooth(trial.u), trial.y)

    @cached_property
    def _given(self) -> list[Array]:
        return [self._side_by_side(trial) for trial in self.trials]

    def _stepped(
        self,
        variants: Sequence[Hypothesis],
        gains: Sequence[Gain],
        starts: Sequence[Array] | None,
    ) -> list[Array]:
        scale = np.array([as_recorded(self.trials[0], v.mechanisms) for v in variants])[:, None]
        return [e * scale for e, _, _ in self.stepped(variants, gains, starts)]

    def stepped(
        self,
        variants: Sequence[Hypothesis],
        gains: Sequence[Gain],
        starts: Sequence[Array] | None,
    ) -> list[tuple[Array, Array, Array]]:
        """Return innovations of corrected outputs, states and memories of variants, by trial."""
        laws = [laws_of(variant.mechanisms) for variant in variants]
        steps = steps_for(laws[0], self._plants(variants[:1])[0][0])
        plants = self._plants(variants, steps)
        whole = not any(changes_data(m) for m in variants[0].mechanisms)
        outputs = self.trials[0].outputs
        limits = np.array([limits_of(v.mechanisms, outputs) for v in variants])

        def one(number: int) -> tuple[Array, Array, Array]:
            trial, n = self.trials[number], len(plants[number][0].A)
            sounds = [corrected(trial, v.mechanisms) for v in (variants[:1] if whole else variants)]
            y = np.array([s.y for s in sounds])
            if trial.blurred is not None:
                y[:, trial.blurred] = np.nan
            return with_laws(
                plants[number],
                gains[number],
                laws,
                np.array([s.u for s in sounds]),
                np.array([self.smooth(s.u) for s in sounds]),
                y,
                np.zeros(n) if starts is None else np.asarray(starts[number]),
                limits,
                steps,
                self.step_s,
                held=self.held,
            )

        every = range(len(self.trials))
        threads = _threads(len(every))
        if threads < 2:
            return [one(number) for number in every]
        with ThreadPoolExecutor(threads) as pool:
            return list(pool.map(one, every))

    def start_effects(self, hypothesis: Hypothesis, gains: Sequence[Gain]) -> list[Array]:
        """Return the innovations of unit initial states, one (n, samples, m) a trial."""
        plants = [row[0] for row in self._plants([hypothesis])]
        trials = zip(self.trials, plants, gains, strict=True)
        return [effect_of_start(plant, its, trial.samples) for trial, plant, its in trials]


def _threads(most: int) -> int:
    """Return how many trials are stepped at once: one in a worker, the other cores have theirs."""
    if multiprocessing.parent_process() is not None:
        return 1
    return min(most, os.cpu_count() or 1)


def steps_for(laws: Sequence[Law], plant: Sampled) -> int:
    """Return the integration steps a sample that these laws need beside a plant of one step.

    Forces are straight lines within a step, so it must be short against the fastest oscillation
    that recordings show.
    """
    model = plant.plant.model
    squares = np.linalg.eigvals(np.linalg.solve(model.M, model.K)).real
    fastest = float(np.sqrt(max(np.max(squares), 0.0))) * plant.step_s / (2 * np.pi)
    abrupt = any(law.abrupt for law in laws)
    least, per_period = (ABRUPT_STEPS, ABRUPT_PER_PERIOD) if abrupt else (STEPS, PER_PERIOD)
    return max(least, math.ceil(per_period * min(fastest, FAST))) if laws else 1
