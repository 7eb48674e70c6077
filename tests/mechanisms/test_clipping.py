"""The end of an instrument's range is read off its samples; a motion that turns is none."""

import numpy as np
import pytest
from scipy.signal import butter, decimate, sosfilt

from twin.mechanisms import vocabulary

Clipping = vocabulary()["sensor_clipping"]
RATE, FINE = 256.0, 8


def resonant(seed, samples=4096, frequencies=(2.6, 6.3, 17.0), fine=FINE):
    """Return a random acceleration with resonances, (samples fine,)."""
    draw = np.random.default_rng(seed)
    out = np.zeros(samples * fine)
    for f in frequencies:
        w, h = 2 * np.pi * f, 1 / (RATE * fine)
        ring = np.exp((-0.02 + 1j) * w * h)
        sos = [[1, 0, 0, 1, -2 * ring.real, abs(ring) ** 2]]
        mode = sosfilt(sos, draw.standard_normal(len(out)))
        out += mode / np.std(mode)
    return out / np.std(out)


def analysed(signal, noise=1e-3, seed=0):
    """Return what an analyser records of a fine signal: filtered, decimated, with noise."""
    out = decimate(signal, FINE, ftype="fir")
    return out + noise * np.random.default_rng(seed).standard_normal(len(out))


@pytest.mark.parametrize("level", [0.6, 1.0, 1.6, 2.2])
def test_a_range_that_ends_before_the_filter_is_found(level):
    reading = analysed(np.clip(resonant(3), -level, level))
    found = Clipping.found("acc_floor1", reading, RATE)
    assert found.level == pytest.approx(level, rel=0.01)
    hidden = found.spoiled(reading)
    sound = analysed(resonant(3))
    assert np.max(np.abs(reading - sound)[~hidden]) < 0.05 * level
    assert np.mean(hidden) < 0.95


def test_a_blow_of_three_samples_is_hidden_with_what_the_filter_leaves_of_it():
    signal, width = 0.4 * resonant(6), round(0.012 * RATE * FINE)
    pulse = np.sin(np.pi * np.arange(width) / width)
    for begin in range(900, len(signal) - width, 2600):
        signal[begin : begin + width] += 2.5 * pulse
    reading, sound = analysed(np.clip(signal, -1.2, 1.2)), analysed(signal)
    hidden = Clipping("acc_floor1", 1.2).spoiled(reading)
    assert np.max(np.abs(reading - sound)[~hidden]) < 0.06
    assert np.mean(hidden) < 0.6


@pytest.mark.parametrize("seed", range(8))
def test_a_sound_channel_has_no_end(seed):
    assert Clipping.found("acc_floor1", analysed(resonant(seed), seed=seed), RATE) is None


@pytest.mark.parametrize("share", [0.0, 0.1, -0.1])
def test_a_steady_tone_and_its_harmonics_have_no_end(share):
    time = np.arange(4096 * FINE) / (RATE * FINE)
    tone = np.sin(2 * np.pi * 3.3 * time) + share * np.sin(6 * np.pi * 3.3 * time)
    assert Clipping.cut_off("acc_floor1", analysed(tone)) is None


def test_a_force_that_yields_smoothly_has_no_end():
    """Summits of all heights are flattened, not those of one."""
    signal = resonant(5)
    assert Clipping.cut_off("acc_floor1", analysed(np.tanh(0.4 * signal))) is None


def test_a_range_ends_in_no_recording_that_goes_farther():
    range_of = Clipping("acc_floor1", 1.0)
    assert range_of.exceeded(np.array([0.2, -1.4]))
    assert not range_of.exceeded(np.array([1.1, -1.0]))


def test_what_a_filter_makes_of_a_motion_that_is_nearly_always_cut_off_stays_within_the_range():
    """Behind eight poles a motion between both ends overshoots by a third of the level."""
    cut = np.clip(40 * resonant(3, frequencies=(1.2,)), -1.0, 1.0)
    seen = sosfilt(butter(8, 0.4 * RATE, fs=RATE * FINE, output="sos"), cut)[::FINE]
    assert np.max(np.abs(seen)) > 1.2
    assert not Clipping("acc_floor1", 1.0).exceeded(seen)
