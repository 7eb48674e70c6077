"""What is not physics but must fit: inputs between samples, noise levels, and the free run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from twin.diagnosis.bench import SLACKS, Bench, Between
from twin.diagnosis.fitting import Fit, fit, gains_of, log_likelihood
from twin.diagnosis.predict import from_rest, nrmse
from twin.diagnosis.refining import refined, with_slack
from twin.diagnosis.trials import Trial

CLEAR = 15.0
"""Gain in log likelihood that a change here must bring."""

TRUSTED = 1e-6
"""Factor on the forces' noise that makes a filter a simulation."""

REPRODUCIBLE = 0.05
"""Largest error of a free run that is taken as evidence: beyond it small errors have grown."""

RUNS_BETTER = 0.9
"""A fit of the free run must take its error down to this share of what it was."""

NOISE_FACTORS = (1e-3, 1e-2, 0.1, 0.3, 3.0)

EVERY = slice(None)

TOO_HIGH = 0.5
"""One-step errors of less than this share of an output's noise say that the noise is less."""

BETWEEN: tuple[Between, ...] = ("band_limited", "linear", "held")


def with_between(bench: Bench, current: Fit) -> tuple[Bench, Fit]:
    """Choose what the inputs do between samples, now that the model can tell."""
    best, chosen = current, bench
    for between in BETWEEN:
        if between == bench.between:
            continue
        other = replace(bench, between=between)
        try:
            found = fit(other, current.hypothesis, current.slack, current.starts, iterations=3)
        except np.linalg.LinAlgError:
            continue
        found = with_slack(other, found)
        if found.log_posterior > best.log_posterior + CLEAR:
            best, chosen = found, other
    if chosen is not bench:
        best = refined(chosen, [best.hypothesis], best.slack, best.starts)
    return chosen, best


def with_noise(bench: Bench, current: Fit) -> tuple[Bench, Fit]:
    """Scale the noise levels of inputs and outputs to what the filter's likelihood likes best.

    They were read off the channels' own roughness, which is signal where a test excites high
    frequencies: of all inputs, of all outputs, or of one output (which a motor's steps shake).
    """
    best, chosen = current, bench
    steps: list[tuple[str, int | slice]] = [("input_noise", EVERY), ("output_noise", EVERY)]
    steps += [("output_noise", output) for output in range(len(bench.trials[0].outputs))]
    for role, which in steps:
        base = chosen
        if isinstance(which, int) and not _read_too_high(base, best, which):
            continue
        for factor in NOISE_FACTORS:
            trials = tuple(_scaled(t, role, which, factor) for t in base.trials)
            other = replace(base, trials=trials)
            try:
                gains = gains_of(other, best.hypothesis, best.slack)
            except np.linalg.LinAlgError:
                continue
            rows = other.innovations([best.hypothesis], gains, best.starts)
            e = tuple(row[0] for row in rows)
            value = log_likelihood(e)
            if value > best.log_likelihood + CLEAR:
                best = replace(best, log_likelihood=value, gains=gains, innovations=e)
                chosen = other
    if chosen is not bench:
        best = refined(chosen, [best.hypothesis], best.slack, best.starts)
    return chosen, best


def _read_too_high(bench: Bench, current: Fit, output: int) -> bool:
    """Return whether one-step errors are far below the noise told of an output: none can be."""
    return all(
        np.std(e[:, output]) < TOO_HIGH * trial.output_noise[output]
        for trial, e in zip(bench.trials, current.innovations, strict=True)
    )


def _scaled(trial: Trial, role: str, which: int | slice, factor: float) -> Trial:
    levels = getattr(trial, role).copy()
    levels[which] *= factor
    return replace(trial, **{role: levels})


def by_free_run(bench: Bench, current: Fit) -> tuple[Bench, Fit]:
    """Fit the free run over whole recordings last, and keep that where it runs better.

    A filter forgives a model slow errors; a simulation does not. Where the motion is reproducible
    and the forces are measured well, the free run is the sharper judge.
    """
    trials = tuple(replace(t, input_noise=TRUSTED * t.input_noise) for t in bench.trials)
    trusting = replace(bench, trials=trials, slacks=SLACKS[:1])
    try:
        found = fit(trusting, current.hypothesis, SLACKS[0], current.starts, iterations=10)
    except np.linalg.LinAlgError:
        return bench, current
    errors = [
        nrmse(b.trials, from_rest(b, f.hypothesis, f.slack))
        for b, f in ((bench, current), (trusting, found))
    ]
    better = errors[1] < min(RUNS_BETTER * errors[0], REPRODUCIBLE)
    return (trusting, found) if better else (bench, current)
