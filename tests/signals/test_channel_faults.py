"""Every detector finds its fault at twice the noise, and none speaks of a sound recording."""

import numpy as np
import pytest
from faults_support import RATE, SAMPLES, structure

from twin.signals.channel_faults import (
    channel_faults,
    clipping,
    dead_tail,
    drift,
    dropouts,
    offset,
    quantisation,
    spikes,
)
from twin.signals.mains import hum
from twin.signals.pair_faults import clock, identical, reversed_polarity
from twin.signals.whitening import innovations, local_scale, prediction_error_filter

TIME = np.arange(SAMPLES) / RATE
FAULTY = range(10)


@pytest.mark.parametrize("batch", range(4))
def test_nothing_is_said_of_200_sound_recordings(batch):
    said = {}
    for seed in range(50 * batch, 50 * batch + 50):
        low, high = ((1.5, 9.0), (0.5, 90.0))[seed // 2 % 2]
        force, motion, _ = structure(seed, low, high, 2048, 10 ** -(1 + seed % 3))
        for name, x, kind in (
            ("force", force, "force"), ("a", motion[:, 0], "acc"), ("b", motion[:, 1], "acc"),
        ):  # fmt: skip
            if found := channel_faults(x, RATE, kind):
                said[seed, name] = found
        pair = (
            reversed_polarity(force, motion[:, 0], RATE),
            identical(motion[:, 0], motion[:, 1]),
            clock(motion[:, 0], motion[:, 1], RATE),
        )
        if any(pair):
            said[seed, "pair"] = pair
    assert not said


@pytest.mark.parametrize("seed", FAULTY)
@pytest.mark.parametrize("mains", [49.95, 60.03, 100.0])
def test_hum_of_twice_the_noise_is_found_with_its_amplitude(seed, mains):
    _, motion, level = structure(seed)
    amplitude = 2 * level[0] * np.sqrt(2)
    found = hum(motion[:, 0] + amplitude * np.sin(2 * np.pi * mains * TIME + seed), RATE)
    assert found.size == pytest.approx(amplitude, rel=0.15)
    assert float(found.words.split()[6]) == pytest.approx(mains, abs=0.02)


def test_hum_that_is_folded_by_a_low_rate_is_found_where_it_folds_to():
    _, motion, level = structure(1, 0.5, 6.0, rate=64.0)
    found = hum(motion[:, 0] + 3 * level[0] * np.sin(2 * np.pi * 50 * TIME * RATE / 64), 64.0)
    assert "at 14 Hz" in found.words


@pytest.mark.parametrize("seed", FAULTY)
def test_an_offset_and_a_drift_of_twice_the_noise_are_found(seed):
    _, motion, level = structure(seed)
    x = motion[:, 0]
    assert offset(x - 2 * level[0]).size == pytest.approx(-2 * level[0], rel=0.2)
    bend = drift(x + 4 * level[0] * (TIME / TIME[-1]) ** 2)
    assert bend.size == pytest.approx(4 * level[0], rel=0.3)


@pytest.mark.parametrize("seed", FAULTY)
def test_wrong_samples_of_twice_what_noise_reaches_are_found_where_they_are(seed):
    _, motion, _ = structure(seed)
    x = motion[:, 0].copy()
    taps = prediction_error_filter(x)
    reached = 8.0 * np.max(local_scale(innovations(x, taps)))
    at = np.random.default_rng(seed).permutation(np.arange(500, SAMPLES - 200, 97))[:6]
    x[at] += 2 * reached * (-1.0) ** np.arange(6)
    found = spikes(x)
    there = {first for first, _ in found.samples}
    assert there <= set(at.tolist())
    assert len(there) >= 4, "next to a blow nothing is said"
    assert found.size == pytest.approx(2 * reached, rel=0.3)


@pytest.mark.parametrize(("apart", "times"), [(2, 16.0), (8, 8.0), (20, 8.0)])
def test_wrong_samples_close_to_each_other_are_found_like_others(apart, times):
    found = 0
    for seed in FAULTY:
        _, motion, _ = structure(seed)
        x = motion[:, 0].copy()
        reached = times * np.max(local_scale(innovations(x, prediction_error_filter(x))))
        x[[1500, 1500 + apart]] += np.array([2, -2]) * reached
        fault = spikes(x)
        found += fault is not None and {k for k, _ in fault.samples} == {1500, 1500 + apart}
    assert found >= 9, "next to a blow nothing is said"


@pytest.mark.parametrize("left", [12, 20, 48])
def test_a_wrong_sample_is_found_where_the_record_ends_before_its_shape(left):
    _, motion, _ = structure(FAULTY[0])
    x = motion[:, 0].copy()
    reached = np.max(local_scale(innovations(x, prediction_error_filter(x))))
    at = {SAMPLES - left - 24, SAMPLES - left}
    x[sorted(at)] += np.array([30, -30]) * reached
    assert {k for k, _ in spikes(x).samples} == at


@pytest.mark.parametrize("seed", FAULTY)
def test_held_samples_are_found_where_they_are(seed):
    _, motion, _ = structure(seed)
    for decimals in (12, 3):
        x = np.round(motion[:, 0] / motion[:, 0].std(), decimals)
        first = 1000 + int(np.argmax(np.abs(np.diff(x[1000:1200]))))
        x[first : first + 20] = x[first]
        x[first + 20] = x[first] + np.sign(x[first + 20] - x[first]) * 1e-2 + 0.05
        assert (first, first + 19) in dropouts(x).samples


@pytest.mark.parametrize("seed", FAULTY)
def test_a_tail_that_stands_still_is_found_with_its_beginning(seed):
    _, motion, level = structure(seed)
    x = motion[:, 0].copy()
    x[3500:] = 0.3 * level[0]
    found = dead_tail(x)
    assert found.samples == ((3500, SAMPLES - 1),)
    force = np.zeros(SAMPLES)
    force[50:56] = 1.0, 3.0, 4.0, 3.0, 2.0, 1.0
    assert dead_tail(force) is None, "a force that rests is no dead channel"


@pytest.mark.parametrize("seed", FAULTY)
def test_steps_that_make_twice_the_noise_are_found(seed):
    _, motion, level = structure(seed)
    step = 2 * level[0] * np.sqrt(12)
    found = quantisation(np.round(motion[:, 0] / step) * step)
    assert found.size == pytest.approx(step)
    fine = level[0] / 4
    assert quantisation(np.round(motion[:, 0] / fine) * fine) is None


def test_a_channel_cut_off_at_its_range_is_clipped():
    _, motion, _ = structure(2)
    x = motion[:, 0] / motion[:, 0].std()
    assert clipping(np.clip(x, -1.2, 1.2)).size > 50
    assert clipping(x) is None


@pytest.mark.parametrize("seed", FAULTY)
def test_a_force_and_an_acceleration_of_opposite_sign_are_told(seed):
    force, motion, _ = structure(seed)
    assert reversed_polarity(force, motion[:, 0], RATE) is None
    if seed % 2:  # a shaken structure is in motion when the record begins
        assert reversed_polarity(force, -motion[:, 0], RATE).words == "its sign is reversed"


def test_one_signal_in_two_channels_is_told_from_two_sensors_at_one_place():
    _, motion, level = structure(3)
    x = motion[:, 0]
    assert identical(x, -2.5 * x + 1).size == pytest.approx(-2.5)
    step = level[0] / 2
    rounded = np.round(x / step) * step
    assert identical(rounded, np.round(1.7 * x / step) * step).size == pytest.approx(1.7, rel=1e-2)
    draw = np.random.default_rng(1)
    beside = np.round((x + level[0] * draw.standard_normal(SAMPLES)) / step) * step
    assert identical(rounded, beside) is None


@pytest.mark.parametrize("seed", [0, 2, 4, 6])
def test_a_clock_that_is_off_is_told_by_how_much(seed):
    _, motion, level = structure(seed, samples=4 * SAMPLES)
    time = np.arange(4 * SAMPLES) / RATE
    late = np.interp(time * (1 - 4e-4), time, motion[:, 0])
    late += level[0] * np.random.default_rng(seed).standard_normal(len(late))
    found = clock(motion[:, 0], late, RATE)
    assert found.size == pytest.approx(4e-4, rel=0.2)


@pytest.mark.parametrize("x", [np.zeros(500), np.ones(500), np.arange(500.0), np.zeros(3)])
def test_nothing_and_next_to_nothing_raise_no_exception(x):
    channel_faults(x, 100.0)
    identical(x, x)
    reversed_polarity(x, x, 100.0)
    clock(x, x, 100.0)
