"""Blows behind an analyser's filter, beside what they were before it."""

import numpy as np
import pytest
from scipy.signal import firwin, resample_poly

from twin.estimation.blows import Blows
from twin.estimation.low_pass import LowPass, interpolated
from twin.estimation.model import Trial

FINE, SAMPLES, REACH = 96, 160, 16
TIME = np.arange(SAMPLES * FINE) / FINE
FILTER = firwin(2 * REACH * FINE + 1, 1 / FINE, window=("kaiser", 10.5))
STEPS = 6


def half_sine(begin, width, peak):
    phase = (TIME - begin) / width
    return np.where((phase > 0) & (phase < 1), peak * np.sin(np.pi * phase), 0.0)


def seen(force):
    return resample_poly(force, 1, FINE, window=FILTER)


def told(force, noise=0.0, column=0):
    """What is found in two inputs of which one is the force, noise beside it."""
    rng = np.random.default_rng(3)
    u = noise * rng.standard_normal((SAMPLES, 2))
    u[:, column] += seen(force)
    return u, Blows(u, LowPass(1.0))


@pytest.mark.parametrize("begin", [70.0, 71.37])
@pytest.mark.parametrize("width", [0.4, 1.02, 3.3])
@pytest.mark.parametrize("peak", [8.0, -8.0])
def test_a_half_sine_is_found_as_it_was_before_the_filter(begin, width, peak):
    force = half_sine(begin, width, peak)
    u, blows = told(force, noise=4e-4, column=1)
    if width > 3:
        assert not blows.each or np.max(np.abs(u[:, 1] - blows.shown()[:, 1])) < 0.02
        return
    found, _ = blows.finely(STEPS)
    assert not np.any(found[:, 0])
    assert np.sum(found[:, 1]) / STEPS == pytest.approx(np.sum(force) / FINE, rel=1e-2)
    parts = np.arange(len(found)) / STEPS
    middle = np.sum(parts * found[:, 1]) / np.sum(found[:, 1])
    assert middle == pytest.approx(begin + width / 2, abs=0.01)
    assert blows.onsets(STEPS)[0] == pytest.approx(begin, abs=1.5 / STEPS)


def test_nothing_is_left_of_the_ringing_and_through_the_filter_all_is_as_it_was_measured():
    force = half_sine(70.2, 1.0, 8.0)
    u, blows = told(force)
    trial = Trial(u, u, np.zeros((SAMPLES, 1)), 1.0, np.array([True, True]), blows=blows)
    assert np.max(np.abs(u[:68, 0])) > 0.2
    assert np.max(np.abs(trial.rest)) < 2e-3
    fine = trial.finely(np.zeros(2, bool), FINE)
    before = fine[: 69 * FINE, 0]
    assert np.max(np.abs(before)) < 2e-3
    np.testing.assert_allclose(seen(fine[:, 0])[20:-20], u[20:-20, 0], atol=4e-3)


def test_a_blow_of_another_shape_leaves_nothing_of_its_ringing_either():
    rising = np.clip((TIME - 70.0) / 1.2, 0, 1) ** 2 * (TIME < 71.2)
    bounced = half_sine(70.0, 0.8, 8.0) + half_sine(75.5, 0.8, 3.0)
    for force in (8.0 * rising, bounced):
        u, blows = told(force)
        found, shown = blows.finely(STEPS)
        assert np.all(found >= 0)
        assert np.sum(found) / STEPS == pytest.approx(np.sum(force) / FINE, rel=5e-3)
        assert np.max(np.abs(u - shown)) < 0.01


def test_each_of_two_blows_far_apart_is_found():
    _, blows = told(half_sine(40.1, 1.0, 8.0) + half_sine(120.6, 0.7, 2.0))
    assert blows.onsets(STEPS) == pytest.approx([40.1, 120.6], abs=1.5 / STEPS)
    late = blows.of_part(100, 150)
    assert late.onsets(STEPS) == pytest.approx([20.6], abs=1.5 / STEPS)
    np.testing.assert_array_equal(late.shown(), blows.shown()[100:150])
    np.testing.assert_array_equal(
        late.finely(STEPS)[0], blows.finely(STEPS)[0][100 * STEPS : 150 * STEPS]
    )


def test_shaking_rests_and_long_pushes_are_no_blows():
    rng = np.random.default_rng(8)
    spectrum = np.fft.rfft(rng.standard_normal(len(TIME)))
    spectrum[np.fft.rfftfreq(len(TIME), 1 / FINE) > 0.4] = 0.0
    shaking = np.fft.irfft(spectrum)
    step = np.where(TIME > 80, 5.0, 0.0)
    for force in (shaking, 0 * TIME, step, half_sine(40.0, 30.0, 5.0)):
        assert not told(force, noise=1e-4)[1].each


def test_a_force_without_blows_is_what_is_limited_to_its_band():
    u = np.sin(0.9 * np.arange(SAMPLES))[:, None]
    trial = Trial(u, u, np.zeros((SAMPLES, 1)), 1.0, np.array([True]))
    fine = trial.finely(np.zeros(1, bool), STEPS)
    np.testing.assert_array_equal(fine, interpolated(u, STEPS))
