import numpy as np
import pytest

from twin.signals.resampling import resample


def multitone(time):
    tones = [(0.4, 0.1), (7.3, 1.0), (15.0, 2.0), (22.0, 0.5)]
    return sum(np.cos(2 * np.pi * f * time + phase) for f, phase in tones)


@pytest.mark.parametrize("new_rate", [2048.0, 1024.0, 77.0, 50.0, 50 * 1023 / 1000])
def test_a_band_limited_signal_is_met_between_its_samples(new_rate):
    before = np.arange(2000) / 50.0
    resampled = resample(multitone(before), 50.0, new_rate)
    time = np.arange(len(resampled)) / new_rate
    inside = (time > 3) & (time < 37)
    assert np.abs(resampled - multitone(time))[inside].max() < 1e-4


def test_the_first_output_is_at_the_first_sample_and_the_last_not_beyond_the_last():
    resampled = resample(np.linspace(0, 1, 101), 100.0, 1024.0)
    assert len(resampled) == 1025
    assert resampled[0] == pytest.approx(0, abs=1e-5)
    assert resampled[-1] == pytest.approx(1, abs=1e-5)


def test_what_lies_beyond_the_new_nyquist_frequency_is_removed():
    time = np.arange(4000) / 200.0
    resampled = resample(np.sin(2 * np.pi * 45.0 * time), 200.0, 50.0)
    assert np.abs(resampled[100:-100]).max() < 1e-4


def test_a_constant_stays_constant_up_to_the_ends():
    assert np.abs(resample(np.full(300, 2.5), 50.0, 1024.0) - 2.5).max() < 1e-4


def test_columns_are_resampled_alike():
    x = np.random.default_rng(1).standard_normal((200, 2))
    both = resample(x, 50.0, 128.0)
    assert both.shape == (199 * 64 // 25 + 1, 2)
    assert np.array_equal(both[:, 1], resample(x[:, 1], 50.0, 128.0))


def test_the_same_rate_gives_the_same_samples():
    x = np.arange(5.0)
    assert np.array_equal(resample(x, 50.0, 50.0), x)


def test_rates_without_a_ratio_of_whole_numbers_are_refused():
    with pytest.raises(ValueError, match="no ratio of whole numbers"):
        resample(np.zeros(10), 1.0, np.pi * 1e-6)
    with pytest.raises(ValueError, match="positive rates"):
        resample(np.zeros(10), 1.0, 0.0)
