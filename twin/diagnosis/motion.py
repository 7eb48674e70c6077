"""The motion behind the recordings: smoothed drifts and rates, and the forces of laws on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.bench import Bench
from twin.diagnosis.channels import corrected, limits_of
from twin.diagnosis.filtering import Filtered, linear, smoothed
from twin.diagnosis.fitting import Fit, gains_of, log_likelihood
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.plant import KNOWN_FORCE, laws_of, place_vector
from twin.diagnosis.trials import Trial
from twin.mechanisms.mechanism import Law
from twin.second_order import SecondOrderModel

Array = NDArray[np.float64]


def states(bench: Bench, fit: Fit) -> list[Array]:
    """Return the smoothed states of every trial, (samples, n); laws must be known forces."""
    hypothesis = fit.hypothesis
    plants = [row[0] for row in bench._plants([hypothesis])]
    if np.isfinite(limits_of(hypothesis.mechanisms, bench.trials[0].outputs)).any():
        # what is cut off says nothing of the motion beyond
        stepped = bench.stepped([hypothesis], fit.gains, fit.starts)
        filtered = [Filtered(e[0], x[0]) for e, x, _ in stepped]
    else:
        filtered = []
        for trial, plant, its, start in zip(
            bench.trials, plants, fit.gains, fit.starts, strict=True
        ):
            sound = corrected(trial, hypothesis.mechanisms)
            filtered.append(linear(plant, its, sound.u, bench.smooth(sound.u), sound.y, start))
    return [
        smoothed(plant, its, each)
        for plant, its, each in zip(plants, fit.gains, filtered, strict=True)
    ]


def at_place(model: SecondOrderModel, state: Array, place: str) -> tuple[Array, Array]:
    """Return drift (or displacement) and rate at a place from states, each (samples,)."""
    b = place_vector(model, place)
    n = len(model.coordinates)
    return state[:, :n] @ b, state[:, n : 2 * n] @ b


def force_histories(
    laws: Sequence[Law], motions: Sequence[tuple[Array, Array]], step_s: float
) -> list[Array]:
    """Return the forces of variants of one law along known motions.

    Args:
        laws: the same law with different values.
        motions: drift and rate of each trial, both (samples,).
        step_s: sampling interval [s].

    Returns:
        One (laws, samples) a trial.
    """
    law = laws[0]
    values = {n: np.array([float(item.values[n]) for item in laws]) for n in law.parameters}
    longest = max(len(drift) for drift, _ in motions)
    d = np.array([np.pad(x, (0, longest - len(x))) for x, _ in motions])[:, None]
    v = np.array([np.pad(x, (0, longest - len(x))) for _, x in motions])[:, None]
    t = np.asarray(step_s * np.arange(longest), float)
    memory = np.zeros((len(motions), len(laws), longest))
    if law.memory:
        batch = law.with_values(values)
        for k in range(1, longest):
            memory[..., k] = batch.remember(memory[..., k - 1], d[..., k - 1], d[..., k])
    batch = law.with_values({n: x[:, None] for n, x in values.items()})
    force = np.broadcast_to(batch.force(d, v, memory, t), memory.shape)
    return [force[i, :, : len(drift)] for i, (drift, _) in enumerate(motions)]


def with_known_forces(
    bench: Bench, fit: Fit, moved: Sequence[Array], memories: Sequence[Array]
) -> tuple[Bench, Hypothesis]:
    """Return bench and hypothesis in which the found laws' forces are measured inputs.

    Args:
        bench: the bench.
        fit: a fitted hypothesis, perhaps with laws.
        moved: the states of every trial, (samples, n).
        memories: the filter's, (samples, laws): what sticks does not tell its force by its rate.
    """
    laws = laws_of(fit.hypothesis.mechanisms)
    if not laws:
        return bench, fit.hypothesis
    rest = tuple(m for m in fit.hypothesis.found if not isinstance(m, Law))
    trials: list[Trial] = []
    for trial, state, memory in zip(bench.trials, moved, memories, strict=True):
        model = bench.plant(trial, fit.hypothesis.mechanisms).plant.model
        names, columns, noise = [], [], []
        for position, law in enumerate(laws):
            drift, rate = at_place(model, state, law.place)
            force = memory[:, position]
            if not law.sticks:
                force = force_histories([law], [(drift, rate)], bench.step_s)[0][0]
            names.append(f"{KNOWN_FORCE}{position}_{law.place}")
            columns.append(force)
            noise.append(0.02 * float(np.sqrt(np.mean(force**2))))
        trials.append(
            replace(
                trial,
                inputs=trial.inputs + tuple(names),
                u=np.column_stack([trial.u, *columns]),
                input_noise=np.concatenate([trial.input_noise, noise]),
            )
        )
    return replace(bench, trials=tuple(trials)), replace(fit.hypothesis, found=rest)


def motion_of(bench: Bench, fit: Fit) -> tuple[list[Array], Bench, Fit]:
    """Return the smoothed states of a fit, and bench and fit with its laws as known forces.

    Where there are laws, the filter's own states give their forces first, and the linear smoother
    runs with those forces as inputs.
    """
    laws = laws_of(fit.hypothesis.mechanisms)
    if not laws:
        return states(bench, fit), bench, fit
    stepped = bench.stepped([fit.hypothesis], fit.gains, fit.starts)
    memories = [z[0] for _, _, z in stepped]
    known, rest = with_known_forces(bench, fit, [x[0] for _, x, _ in stepped], memories)
    plain = refit_gains(known, rest, fit)
    moved = states(known, plain)
    known, rest = with_known_forces(bench, fit, moved, memories)
    return moved, known, refit_gains(known, rest, fit)


def refit_gains(bench: Bench, hypothesis: Hypothesis, fit: Fit) -> Fit:
    """Return a fit with the same values for another bench, its gains and innovations anew."""
    gains = gains_of(bench, hypothesis, fit.slack)
    rows = bench.innovations([hypothesis], gains, fit.starts)
    e = tuple(row[0] for row in rows)
    return replace(
        fit,
        hypothesis=hypothesis,
        unknowns=hypothesis.unknowns(),
        gains=gains,
        innovations=e,
        log_likelihood=log_likelihood(e),
    )
