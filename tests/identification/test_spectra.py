import numpy as np
import pytest

from twin.errors import IdentificationError
from twin.identification.spectra import excited_band, hit_window, spectrum


def test_white_noise_keeps_its_variance_in_every_bin():
    x = 3 * np.random.default_rng(0).standard_normal((200_000, 1))
    s = spectrum(x, x, 0.01, (0, 50))
    assert np.mean(np.abs(s.Y) ** 2) == pytest.approx(9, rel=0.02)


def test_offset_and_nyquist_lines_are_left_out():
    s = spectrum(np.ones((64, 1)), np.ones((64, 1)), 1 / 64, (0, 32))
    assert len(s.omega) == 31
    assert np.abs(s.Y).max() < 1e-12


def test_a_band_without_lines_is_refused():
    with pytest.raises(IdentificationError, match="no frequency line lies between 40 and 50 Hz"):
        spectrum(np.ones((64, 1)), np.ones((64, 1)), 1 / 64, (40, 50))


def test_the_band_of_a_multisine_is_that_of_its_lines():
    t = np.arange(4000) / 100
    u = sum(np.sin(2 * np.pi * f * t + f**2) for f in np.arange(2, 15, 0.25))[:, None]
    low, high = excited_band([u], 0.01)
    assert low == pytest.approx(2, abs=0.5)
    assert high == pytest.approx(15, abs=0.5)


def test_smoothing_does_not_smear_the_end_of_a_multisine():
    samples = 8192
    t = np.arange(samples) / 400
    lines = np.arange(41, 308) * 400 / samples
    u = sum(np.sin(2 * np.pi * f * t + f**2) for f in lines)[:, None]
    low, high = excited_band([u], 1 / 400)
    assert (low, high) == pytest.approx((lines[0], lines[-1]), rel=1e-9)


def test_free_samples_count_by_what_the_band_feels_of_them():
    u = np.random.default_rng(4).standard_normal((4000, 1))
    whole = spectrum(u, u, 0.01, (0, 50), edge=8).edge_columns
    assert whole.shape[1] == 16
    narrow = spectrum(u, u, 0.01, (0.3, 7), edge=8)
    columns = np.vstack([narrow.edge_columns.real, narrow.edge_columns.imag])
    assert 4 <= columns.shape[1] < 12
    assert np.linalg.cond(columns) < 1.1e3
    # No pulse at an end is felt beyond what the combinations hold.
    pulse = np.zeros((4000, 1))
    pulse[3] = 1
    felt = spectrum(pulse, pulse, 0.01, (0.3, 7)).Y[:, 0]
    felt = np.concatenate([felt.real, felt.imag])
    left = felt - columns @ np.linalg.lstsq(columns, felt, rcond=None)[0]
    assert np.linalg.norm(left) < 4e-3 * np.linalg.norm(felt)


def test_the_band_never_reaches_the_anti_alias_filter():
    u = np.random.default_rng(1).standard_normal((4000, 1))
    assert excited_band([u], 0.01)[1] <= 100 / 2.56


def test_a_hit_is_found_in_noise():
    u = 1e-3 * np.random.default_rng(2).standard_normal((1000, 1))
    u[300:304, 0] = 1, 3, 2, 0.5
    start, stop = hit_window(u)
    assert start in range(290, 301)
    assert stop in range(304, 312)


def test_shaking_is_no_hit():
    assert hit_window(np.random.default_rng(3).standard_normal((1000, 1))) is None
