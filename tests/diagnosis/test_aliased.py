"""What an analyser folds of a blow, beside a simulation in fine steps and scipy's filter."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from twin.diagnosis.aliased import aliased
from twin.diagnosis.beginning import start_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.measured import Measured
from twin.diagnosis.problem import Problem
from twin.diagnosis.trials import trial_of
from twin.estimation.averages import averages_at
from twin.estimation.likelihood import passes
from twin.estimation.sensitivities import plants_of
from twin.model import Twin
from twin.model.free_run import free_run
from twin.model.transfer import transfer

RATE, TIMES, SAMPLES, AT = 64.0, 16, 512, 128
QUIET = np.zeros(1)
INPUTS, OUTPUTS = ("force_floor2",), ("acc_floor1", "acc_floor2")


def model():
    return Twin.load("two_storey_lumped").linear(INPUTS, OUTPUTS)


def struck(contact_s):
    """Force and accelerations of a blow behind an analyser's filter that folds a little."""
    t = np.arange(SAMPLES * TIMES) / (RATE * TIMES) - AT / RATE
    blow = np.exp(-0.5 * (t / (contact_s / 4)) ** 2)[:, None]
    moved = free_run(model(), blow, RATE * TIMES)
    sections = butter(8, 0.45 * RATE, fs=RATE * TIMES, output="sos")
    return tuple(sosfiltfilt(sections, x, axis=0)[::TIMES] for x in (blow, moved))


def missed(u, y):
    """What a free run that takes the force as band-limited misses."""
    spectrum = np.fft.rfft(u, axis=0)
    spectrum[-1] /= 2  # at half the rate, of which there are two in finer steps
    fine = np.fft.irfft(spectrum, TIMES * len(u), axis=0) * TIMES
    return y - free_run(model(), fine, RATE * TIMES)[::TIMES]


def test_a_short_blow_is_missed_by_what_was_folded_and_no_more():
    u, y = struck(0.012)
    error = missed(u, y)
    allowed = np.sqrt(aliased(model(), u, 1 / RATE, QUIET))
    around = slice(AT - 4, AT + 5)
    rms = np.sqrt(np.mean(error[around] ** 2, axis=0))
    assert np.all(rms < np.sqrt(np.mean(allowed[around] ** 2, axis=0)))
    assert np.all(rms > 0.02 * np.sqrt(np.mean(allowed[around] ** 2, axis=0)))
    assert np.all(np.max(allowed[: AT - 60], axis=0) < 0.1 * np.max(allowed, axis=0))


def test_a_blow_of_a_soft_tip_is_not_folded():
    short, long = (np.max(aliased(model(), struck(s)[0], 1 / RATE, QUIET)) for s in (0.012, 0.12))
    assert long < 1e-5 * short


def test_noise_of_an_input_is_no_folded_force():
    noise = 0.01 * np.random.default_rng(2).standard_normal((SAMPLES, 1))
    assert not np.any(aliased(model(), noise, 1 / RATE, np.array([0.01])))
    assert np.all(np.any(aliased(model(), noise, 1 / RATE, np.array([0.001])), axis=0))
    # what noise alone makes is what the bound counts on
    power = np.mean(aliased(model(), noise, 1 / RATE, QUIET), axis=0)
    alike = [
        np.mean(aliased(model(), 0.01 * np.random.default_rng(k).standard_normal((SAMPLES, 1)),
                        1 / RATE, QUIET), axis=0)
        for k in range(3, 8)
    ]  # fmt: skip
    np.testing.assert_allclose(power, np.mean(alike, axis=0), rtol=0.5)


def test_the_gain_is_that_of_the_equations():
    f = np.array([1.0, 20.0])
    found, here = transfer(model(), 2j * np.pi * f), model()
    for k, w in enumerate(2 * np.pi * f):
        q = np.linalg.solve(here.K + 1j * w * here.R - w**2 * here.M, here.B)
        np.testing.assert_allclose(found[k], -(w**2) * here.Ca @ q + here.Cu, rtol=1e-9)


@pytest.fixture(scope="module")
def problem():
    u, y = struck(0.012)
    levels = 1e-4 * np.ones(2)
    y = y + 1e-4 * np.random.default_rng(1).standard_normal(y.shape)
    measured = Measured("a", u, y, np.array([1e-9]), levels)
    scale = np.full((1, 2), 1e-3)
    return Problem(model(), (measured,), RATE, 0.01, 0.3, ("band_limited",), scale)


def test_outputs_are_believed_less_for_as_long_as_the_blow_lasts(problem):
    trial = trial_of(problem, problem.recordings[0])
    assert np.all(trial.blur[AT] > problem.recordings[0].output_noise ** 2)
    assert np.all(trial.blur[-200:] < 1e-2 * trial.blur[AT])
    straight = replace(problem, between=("linear",))
    assert trial_of(straight, straight.recordings[0]).blur is None


def test_a_twin_without_laws_has_it_in_its_averages(problem):
    blank = Hypothesis(problem)
    here = blank.assemble(start_of(blank))
    found = averages_at(blank, here, plants_of(here, blank), 0)
    np.testing.assert_array_equal(found.blur, problem.trials[0].blur)
    (run,) = passes(blank, start_of(blank))
    assert np.all(np.isfinite(run.e))
