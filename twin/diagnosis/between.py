"""What the inputs do between samples, by evidence.

What one analyser measured is alike between samples; what motors were commanded is another thing (a
computer holds its output), so the two are asked for apart.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import start_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.problem import Between, Problem
from twin.estimation.fit import Fit, fit
from twin.estimation.likelihood import evaluate

Array = NDArray[np.float64]

FEW = 6
"""Gauss-Newton steps that tell what the inputs do between samples: they differ by thousands of
nats where it matters."""

ENOUGH = 3.0
"""Evidence [nat] for anything but band-limited inputs: the odds of 1 to 20 that analysers are."""

KINDS: dict[Between, str] = {
    "band_limited": "band-limited between the samples",
    "linear": "straight lines between the samples",
    "held": "held from sample to sample",
}


def choose(problem: Problem) -> tuple[Problem, Array]:
    """Return the problem with what the inputs do between samples, and a calibration.

    Band-limited unless another is better from there on.
    """
    count = len(problem.model.inputs)
    best: tuple[float, Problem, Array] | None = None
    for kind in KINDS:
        tried = replace(problem, between=(kind,) * count)
        blank = Hypothesis(tried)
        if best is None:
            found = fit(blank, start_of(blank))
            best = found.log_evidence, tried, found.z
            continue
        found = fit(blank, best[2], most=FEW, hopeless=best[0])
        if found.log_evidence > best[0] + ENOUGH:
            best = found.log_evidence, tried, found.z
    assert best is not None
    hypothesis = Hypothesis(best[1])
    hypothesis, found = again(hypothesis, fit(hypothesis, best[2]))
    return hypothesis.problem, found.z


def again(hypothesis: Hypothesis, found: Fit) -> tuple[Hypothesis, Fit]:
    """Return a fit with other inputs between the samples where these are likelier now.

    A twin that lacks much takes the inputs for what they are not. Where the likelihood at the same
    values is greater, the fit is made again.
    """
    own = hypothesis.problem.between
    likeliest, best = own, found.log_likelihood - _odds(own)
    for between in _others(hypothesis.problem):
        other = replace(hypothesis, problem=replace(hypothesis.problem, between=between))
        value = evaluate(other, found.z, derivatives=False).log_likelihood
        if value - _odds(between) > best:
            likeliest, best = between, value - _odds(between)
    if likeliest == own:
        return hypothesis, found
    other = replace(hypothesis, problem=replace(hypothesis.problem, between=likeliest))
    return other, fit(other, found.z)


def in_words(problem: Problem) -> str:
    """Say what the inputs are taken for between the samples."""
    names = dict.fromkeys(KINDS, "")
    for name, kind in zip(problem.model.inputs, problem.between, strict=True):
        names[kind] += f", {name}" if names[kind] else name
    if len(set(problem.between)) == 1:
        return f"the inputs are taken as {KINDS[problem.between[0]]}"
    return "; ".join(f"{who} taken as {KINDS[kind]}" for kind, who in names.items() if who)


def _others(problem: Problem) -> Iterator[tuple[Between, ...]]:
    """Yield what else the inputs could do: those that were measured, and motors' commands."""
    driven = [name in problem.model.driven for name in problem.model.inputs]
    for group in sorted(set(driven)):
        for kind in KINDS:
            tried = tuple(
                kind if mine == group else now
                for mine, now in zip(driven, problem.between, strict=True)
            )
            if tried != problem.between:
                yield tried


def _odds(between: Sequence[Between]) -> float:
    """Return the log odds against kinds of inputs [nat]."""
    return ENOUGH * len(set(between) - {"band_limited"})
