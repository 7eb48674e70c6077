import numpy as np
import pytest

from twin.signals.low_pass import anti_alias, decimate, low_pass


@pytest.mark.parametrize(
    ("sampling_hz", "factor"), [(32.0, 32), (32.0, 64), (100.0, 11), (512.0, 8)]
)
def test_the_analyser_is_flat_to_fs_over_2_56_and_blind_to_what_would_alias_into_it(
    sampling_hz, factor
):
    filter_ = anti_alias(sampling_hz, factor)
    frequency = np.linspace(0, sampling_hz * factor / 2, 20_001)
    gain = filter_.gain(frequency)
    flat = frequency <= sampling_hz / 2.56
    stopped = frequency >= sampling_hz - sampling_hz / 2.56
    assert np.abs(gain[flat] - 1).max() < 1e-5
    assert np.abs(gain[stopped]).max() < 1e-5  # -100 dB


def test_the_cut_off_is_the_papers_16_hz_at_32_hz():
    assert anti_alias(32.0, 64).gain(np.array([16.0])) == pytest.approx(0.5, abs=1e-5)


def test_another_cut_off_scales_both_edges():
    filter_ = anti_alias(32.0, 64, cut_off_hz=8.0)
    assert filter_.gain(np.array([8.0])) == pytest.approx(0.5, abs=1e-5)
    assert filter_.gain(np.array([6.25])) == pytest.approx(1, abs=1e-5)
    assert np.abs(filter_.gain(np.array([9.75, 16.0, 30.0]))).max() < 1e-5


def test_a_tone_in_the_band_keeps_its_samples_to_the_very_ends_of_the_record():
    filter_ = anti_alias(32.0, 32)
    n = np.arange(-filter_.reach, 32 * 100 + filter_.reach + 1)
    history = np.cos(2 * np.pi * 6.7 * n / 1024 + 0.3)
    record = decimate(history, 32, filter_)
    assert len(record) == 101
    expected = np.cos(2 * np.pi * 6.7 * np.arange(101) / 32 + 0.3)
    assert np.abs(record - expected).max() < 1e-5


def test_a_tone_that_would_alias_is_gone():
    filter_ = anti_alias(32.0, 32)
    n = np.arange(32 * 100)
    record = decimate(np.cos(2 * np.pi * 27.0 * n / 1024), 32, filter_)  # would be seen at 5 Hz
    assert np.abs(record).max() < 1e-5


def test_channels_are_filtered_alike():
    filter_ = anti_alias(32.0, 32)
    one = np.random.default_rng(0).standard_normal(3000)
    both = decimate(np.column_stack([one, 2 * one]), 32, filter_)
    assert np.array_equal(both[:, 0], decimate(one, 32, filter_))
    assert np.allclose(both[:, 1], 2 * both[:, 0], rtol=1e-14)


def test_decimation_never_makes_up_samples():
    filter_ = anti_alias(32.0, 32)
    with pytest.raises(ValueError, match="fewer than the filter's"):
        decimate(np.zeros(len(filter_.taps) - 1), 32, filter_)
    assert len(decimate(np.zeros(len(filter_.taps)), 32, filter_)) == 1


def test_a_reach_that_does_not_fit_the_factor_is_refused():
    with pytest.raises(ValueError, match="no multiple"):
        decimate(np.zeros(5000), 31, anti_alias(32.0, 32))


@pytest.mark.parametrize("edges", [(0.0, 5.0), (5.0, 5.0), (6.0, 5.0), (5.0, 51.0)])
def test_impossible_edges_are_refused(edges):
    with pytest.raises(ValueError, match="no low-pass"):
        low_pass(100.0, *edges)
