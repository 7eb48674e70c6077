"""A law is stepped as finely as its port moves; noise that a poorer twin needed is let go."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.explanation import Explanation, from_prior_noise
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.parts import (
    HARMONIC,
    MOST_STEPS,
    NARROW,
    OUT_OF_STEP,
    STEPS,
    parts_of,
    yielding,
)
from twin.diagnosis.prepare import prepare
from twin.diagnosis.scales import Scales
from twin.estimation.fit import fit
from twin.mechanisms.cubic_stiffness import CubicStiffness


@pytest.fixture(scope="module")
def problem():
    return prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train


@pytest.mark.parametrize("samples_a_period", [200.0, 30.0, 12.0, 9.0, 3.0])
def test_the_midpoint_rule_is_in_step_with_the_third_harmonic(problem, samples_a_period):
    w = 2 * np.pi * problem.sampling_hz / samples_a_period
    law, prior = CubicStiffness("storey2", 1e5), {"stiffness": (1e5, 1e5)}
    scales = Scales({"storey2": (1.0, 1e-3, 1e-3 * w)})
    h = Hypothesis(problem, (law,), (prior,), scales)
    steps = h.assemble(np.zeros(len(h.unknowns))).steps
    assert STEPS <= steps <= MOST_STEPS
    error = (HARMONIC * w * problem.step_s / steps) ** 2 / 12
    assert error <= OUT_OF_STEP or steps == MOST_STEPS
    coarser = (HARMONIC * w * problem.step_s / (steps - 1)) ** 2 / 12
    assert coarser > OUT_OF_STEP or steps == STEPS
    assert Hypothesis(problem).assemble(np.zeros(len(Hypothesis(problem).unknowns))).steps == 1


def test_a_fit_held_back_by_its_noise_is_made_again(problem):
    h = Hypothesis(problem)
    noisy = np.array([u.role == "noise" for u in h.unknowns])
    stuck = fit(h, np.where(noisy, 4.0, 0.0), most=1)
    before = Explanation(h, stuck, stuck.log_evidence - 3.0)
    after = from_prior_noise(before)
    assert after.fit.log_evidence > stuck.log_evidence + 10
    assert after.log_odds == pytest.approx(after.fit.log_evidence - 3.0)
    settled = replace(before, fit=after.fit, log_odds=after.log_odds)
    assert from_prior_noise(settled).log_odds >= settled.log_odds


def test_what_holds_moves_no_resonance_by_much_of_its_width(problem):
    slow = np.array([[1.0, 1.0, 1e-3]])
    assert parts_of(problem, slow, every_mode=False) == STEPS
    fast = replace(problem, sampling_hz=3.3 * np.max(problem.frequencies))
    w = 2 * np.pi * fast.frequencies
    seconds = len(fast.recordings[0].y) * fast.step_s

    def allowed(damping):
        """Greatest relative error of a force, by the damping ratio of each mode."""
        return np.minimum(OUT_OF_STEP, 4 * NARROW * np.maximum(damping, np.pi / (w * seconds)))

    for light in (1.0, 0.2, 1e-6):
        model = replace(fast.model, R=light * fast.model.R)
        damping = np.diag(model.R) / (2 * w * np.diag(model.M))
        parts = parts_of(replace(fast, model=model), slow, every_mode=True)
        assert np.all((w * fast.step_s / parts) ** 2 / 12 <= allowed(damping))
        assert np.any((w * fast.step_s / (parts - 1)) ** 2 / 12 > allowed(damping))


def test_a_port_yields_within_a_part_that_its_modes_are_too_fast_for(problem):
    places, slowest = ["storey1", "storey2"], 2 * np.pi * np.min(problem.frequencies)
    w = 2 * np.pi * np.max(problem.frequencies)
    # where no mode is too fast nothing yields; where the slowest is, everything does
    assert not np.any(yielding(problem, places, 0.8 * np.sqrt(12 * OUT_OF_STEP) / w))
    assert np.all(yielding(problem, places, 1.01 * np.sqrt(12 * OUT_OF_STEP) / slowest))
