"""What the inputs do between samples, by evidence.

What one analyser measured is alike between samples; what motors were commanded is another thing (a
computer holds its output), so the two are asked for apart.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import attempted, likeliest, start_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.portion import on_a_part
from twin.diagnosis.problem import Between, Problem
from twin.estimation.fit import Fit, fit

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
    blank = Hypothesis(problem)
    hypothesis, found = again(blank, fit(blank, start_of(blank)))
    return hypothesis.problem, found.z


def again(hypothesis: Hypothesis, found: Fit, steps: int = FEW) -> tuple[Hypothesis, Fit]:
    """Return a fit with other inputs between the samples where these are likelier now.

    A twin that lacks much takes the inputs for what they are not. Others are fitted from where it
    is, a few steps each, those that were measured and motors' commands in turn.

    Args:
        hypothesis: what was fitted.
        found: its fit.
        steps: of a fit with other inputs; with none only the likelihood at the same values counts.
    """
    if steps and not _open(hypothesis, found, steps):
        return hypothesis, found
    for group in sorted({_driven(hypothesis.problem, i) for i in hypothesis.problem.model.inputs}):
        own = _odds(hypothesis.problem.between)
        best = hypothesis, found, found.log_evidence - own
        for between in _others(hypothesis.problem, group):
            problem = replace(hypothesis.problem, between=between)
            other = replace(hypothesis, problem=problem)
            odds = _odds(between)
            if not steps and likeliest(other, [found.z])[0] - odds <= found.log_posterior - own:
                continue
            tried = attempted(other, found.z, max(steps, 1), found.log_posterior + odds - own)
            if tried is not None and tried.log_evidence - odds > best[2]:
                best = other, tried, tried.log_evidence - odds
        if best[0] is not hypothesis:
            hypothesis, found = best[0], fit(best[0], best[1].z)
    return hypothesis, found


def _open(hypothesis: Hypothesis, found: Fit, steps: int) -> bool:
    """Return whether a part of the samples leaves it open that other inputs are likelier."""
    part = on_a_part(hypothesis)
    if part is None:
        return True
    own = attempted(part, found.z, steps)
    if own is None:
        return True
    least = own.log_evidence - _odds(hypothesis.problem.between)
    for group in sorted({_driven(part.problem, i) for i in part.problem.model.inputs}):
        for between in _others(part.problem, group):
            other = replace(part, problem=replace(part.problem, between=between))
            odds = _odds(between)
            tried = attempted(other, own.z, steps, least + odds)
            if tried is not None and tried.log_evidence - odds > least:
                return True
    return False


def in_words(problem: Problem) -> str:
    """Say what the inputs are taken for between the samples."""
    names = dict.fromkeys(KINDS, "")
    for name, kind in zip(problem.model.inputs, problem.between, strict=True):
        names[kind] += f", {name}" if names[kind] else name
    if len(set(problem.between)) == 1:
        return f"the inputs are taken as {KINDS[problem.between[0]]}"
    return "; ".join(f"{who} taken as {KINDS[kind]}" for kind, who in names.items() if who)


def _others(problem: Problem, driven: bool) -> Iterator[tuple[Between, ...]]:
    """Yield what else the measured inputs, or motors' commands, could do."""
    for kind in KINDS:
        tried = tuple(
            kind if _driven(problem, name) == driven else now
            for name, now in zip(problem.model.inputs, problem.between, strict=True)
        )
        if tried != problem.between:
            yield tried


def _driven(problem: Problem, name: str) -> bool:
    return name in problem.model.driven


def _odds(between: Sequence[Between]) -> float:
    """Return the log odds against kinds of inputs [nat]."""
    return ENOUGH * len(set(between) - {"band_limited"})
