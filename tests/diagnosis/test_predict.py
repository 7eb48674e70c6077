"""Predictions: free runs that begin in motion, two seconds ahead, and what noise allows."""

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.predict import HOPELESS, noise_floors, nrmse, placed, predictors
from twin.diagnosis.prepare import prepare

NOISE = 2e-3


@pytest.fixture(scope="module")
def begun():
    """A known rig beside a test that begins in motion; nothing is fitted."""
    train, whole = recorded(lumped(), 1, noise=NOISE), recorded(lumped(), 2, noise=NOISE)
    ready = prepare(lumped(), [train], [whole.trim(600, whole.samples)])
    hypothesis = Hypothesis(ready.train)
    z = np.zeros(len(hypothesis.unknowns))
    return predictors(*placed(hypothesis, z, ready.test)), [r.y for r in ready.test.recordings]


def test_a_free_run_starts_from_the_motion_that_the_recording_begins_in(begun):
    beside, measured = begun
    level = NOISE / np.sqrt(np.mean(measured[0] ** 2))
    assert nrmse(measured, [s.free() for s in beside]) < 1.3 * level
    assert nrmse(measured, [s.from_rest() for s in beside]) > 20 * level


def test_two_seconds_ahead_is_as_good_as_the_noise(begun):
    beside, measured = begun
    level = NOISE / np.sqrt(np.mean(measured[0] ** 2))
    assert nrmse(measured, [s.ahead() for s in beside]) < 1.3 * level


def test_the_floor_is_what_the_true_model_reaches(begun):
    beside, measured = begun
    free, near = noise_floors(beside)
    assert nrmse(measured, [s.free() for s in beside]) == pytest.approx(free, rel=0.2)
    assert nrmse(measured, [s.ahead() for s in beside]) == pytest.approx(near, rel=0.2)


def test_samples_that_are_left_out_do_not_count_and_what_diverges_is_hopeless():
    measured = [np.array([[1.0], [np.nan], [-1.0]])]
    assert nrmse(measured, [np.array([[1.0], [9.0], [-2.0]])]) == pytest.approx(np.sqrt(0.5))
    assert nrmse(measured, [np.array([[1.0], [np.inf], [-1.0]])]) == HOPELESS
