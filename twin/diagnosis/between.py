"""What the inputs do between samples, by evidence."""

from __future__ import annotations

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

BETWEEN: dict[Between, str] = {
    "band_limited": "the inputs are taken as band-limited between the samples",
    "linear": "the inputs are taken as straight lines between the samples",
    "held": "the inputs are taken as held from sample to sample",
}


def choose(problem: Problem) -> tuple[Problem, Array]:
    """Return the problem with what the inputs do between samples, and a calibration.

    Band-limited unless another is better from there on.
    """
    best: tuple[float, Problem, Array] | None = None
    for between in BETWEEN:
        tried = replace(problem, between=between)
        blank = Hypothesis(tried)
        if best is None:
            found = fit(blank, start_of(blank))
            best = found.log_evidence, tried, found.z
            continue
        found = fit(blank, best[2], most=FEW, hopeless=best[0])
        if found.log_evidence > best[0] + ENOUGH:
            best = found.log_evidence, tried, found.z
    assert best is not None
    return best[1], best[2]


def again(hypothesis: Hypothesis, found: Fit) -> tuple[Hypothesis, Fit]:
    """Return a fit with other inputs between the samples where these are likelier now.

    A twin that lacks much takes the inputs for what they are not. Where the likelihood at the same
    values is greater, the fit is made again.
    """
    own = hypothesis.problem.between
    likeliest, best = own, found.log_likelihood - ENOUGH * (own != "band_limited")
    for between in BETWEEN:
        if between == own:
            continue
        other = replace(hypothesis, problem=replace(hypothesis.problem, between=between))
        value = evaluate(other, found.z, derivatives=False).log_likelihood
        if value - ENOUGH * (between != "band_limited") > best:
            likeliest, best = between, value - ENOUGH * (between != "band_limited")
    if likeliest == own:
        return hypothesis, found
    other = replace(hypothesis, problem=replace(hypothesis.problem, between=likeliest))
    return other, fit(other, found.z)
