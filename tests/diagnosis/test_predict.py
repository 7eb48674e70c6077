"""Predictions: free runs that begin in motion, two seconds ahead, and what noise allows."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.predict import HOPELESS, noise_floors, nrmse, placed, predictors
from twin.diagnosis.prepare import prepare
from twin.instruments import Instrument
from twin.laboratory import Analyser, Experiment, RandomShaking, run
from twin.model import Twin

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


@pytest.fixture(scope="module")
def quick():
    """A beam that is shaken up to three quarters of half the sampling rate."""
    beam, rate, noisy = Twin.load("cantilever"), 192.0, Instrument(noise_fraction=0.005)
    of_kinds = {"acc": noisy, "force": noisy}
    analyser = Analyser(rate, 6.0)
    train, test = (
        run(Experiment(RandomShaking(rms, (0.5, 70.0)), ("force_mid", "force_tip"), analyser,
                       None, of_kinds), beam, seed)
        for seed, rms in enumerate((0.03, 0.02))
    )  # fmt: skip
    ready = prepare(beam, [train], [test])
    smooth = ("band_limited",) * len(ready.train.between)
    return replace(ready, train=replace(ready.train, between=smooth))


def test_a_prediction_holds_what_inputs_near_half_the_sampling_rate_do_between_samples(quick):
    hypothesis = Hypothesis(quick.train)
    z = np.zeros(len(hypothesis.unknowns))
    (beside,) = predictors(*placed(hypothesis, z, quick.test))
    measured = [quick.test.recordings[0].y]
    assert nrmse(measured, [beside.free()]) < 0.015
    assert nrmse(measured, [beside.ahead()]) < 0.015
    deaf = replace(beside, trial=replace(beside.trial, missed=None))
    assert nrmse(measured, [deaf.free()]) > 0.1


def test_where_laws_began_in_the_fit_tells_nothing_of_other_recordings(quick):
    hypothesis = replace(Hypothesis(quick.train), begun=(np.ones(4),))
    there, _ = placed(hypothesis, np.zeros(len(hypothesis.unknowns)), quick.test)
    assert there.begun == ()


def test_noise_beside_other_recordings_is_no_more_than_it_was_in_the_fit(quick):
    hypothesis = Hypothesis(quick.train)
    names = [u.name for u in hypothesis.unknowns]
    (train,), (test,) = quick.train.recordings, quick.test.recordings
    z = np.zeros(len(names))
    at = names.index(f"noise of acc_tip in {train.name}")
    z[at] = -3.0  # far below what differences of samples make of so quick a signal
    there, values = placed(hypothesis, z, quick.test)
    level = {u.name: u.value(v) for u, v in zip(there.unknowns, values, strict=True)}
    fitted = hypothesis.unknowns[at].value(-3.0)
    assert np.std(test.y[:, -1]) < np.std(train.y[:, -1])
    assert level[f"noise of acc_tip in {test.name}"] == pytest.approx(fitted)


def test_samples_that_are_left_out_do_not_count_and_what_diverges_is_hopeless():
    measured = [np.array([[1.0], [np.nan], [-1.0]])]
    assert nrmse(measured, [np.array([[1.0], [9.0], [-2.0]])]) == pytest.approx(np.sqrt(0.5))
    assert nrmse(measured, [np.array([[1.0], [np.inf], [-1.0]])]) == HOPELESS
