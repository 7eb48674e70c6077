"""The band in which a shaken structure is diagnosed, and the noise that is seen above it."""

import numpy as np

from twin.diagnosis.band import banded, one_rate
from twin.recording import Recording

RATE = 200.0
T = np.arange(round(60 * RATE)) / RATE


def record(frequency=1.0, fast=0.0, noise=0.0, source="r.csv"):
    draw = np.random.default_rng(1)
    slow = np.sin(2 * np.pi * frequency * T)
    columns = {
        "acc_ground": slow + noise * draw.standard_normal(len(T)),
        "acc_floor1": slow + fast * np.sin(2 * np.pi * 20.0 * T),
    }
    return Recording.build(RATE, columns, source)


def test_a_slow_motion_is_thinned_out_and_that_is_said():
    found = banded([record()], 1, 1.0, 100)
    rate = found.recordings[0].sampling_hz
    assert 5.0 <= rate <= 6.0
    np.testing.assert_allclose(
        found.recordings[0].column("acc_floor1"),
        np.sin(2 * np.pi * np.arange(found.recordings[0].samples) / rate), atol=0.02,
    )  # fmt: skip
    assert f"{rate:.4g} Hz" in found.notes[0]


def test_the_better_the_numbers_are_known_the_wider_is_the_band():
    quick = record(fast=0.05)
    assert banded([quick], 1, 1.0, 100).recordings[0].sampling_hz < 10
    assert banded([quick], 1, 0.1, 100).recordings[0].sampling_hz >= 100
    assert banded([record(noise=0.01, fast=0.01)], 1, 0.004, 100).notes == ()


def test_test_recordings_do_not_choose_the_band_and_samples_enough_are_kept():
    both = [record(), record(fast=1.0, source="test.csv")]
    assert banded(both, 1, 1.0, 100).recordings[1].sampling_hz < 6
    assert banded([record()], 1, 1.0, 1200).recordings[0].samples >= 1200


def test_the_noise_of_the_input_is_that_seen_above_the_band():
    found = banded([record(noise=1e-3)], 1, 1.0, 100)
    rate = found.recordings[0].sampling_hz
    np.testing.assert_allclose(found.input_noise["r.csv"], 1e-3 * np.sqrt(rate / RATE), rtol=0.1)


def test_other_rates_are_brought_to_one_and_that_is_noted():
    notes = []
    first, second = one_rate([record(), record()], 100.0, notes)
    assert first.sampling_hz == second.sampling_hz == 100.0
    assert notes[0] == "r.csv: resampled from 200 to 100 Hz"
