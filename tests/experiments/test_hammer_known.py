"""The part whose modes are known, of the benchmark of damping, and its tables."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import hammer_tables
from hammer_known import Part, other_phases

RATE = 25_600.0


def blow(samples):
    """A smooth blow that holds nothing above half the rate."""
    t = np.arange(samples) / RATE - 0.01
    return 50 * np.exp(-((t / 2e-4) ** 2))


def test_its_response_over_its_force_is_the_accelerance():
    part = Part(
        np.array([900.0, 3000.0]), np.array([0.01, 0.004]), np.array([[1.2, 0.0], [-0.5, 900.0]]),
        0.3, (),
    )  # fmt: skip
    force = blow(25_600)
    H = np.fft.rfft(part.response(force, RATE)) / np.fft.rfft(force)
    freq = np.fft.rfftfreq(25_600, 1 / RATE)
    inside = (freq > 300) & (freq < 4000) & (np.arange(len(freq)) % 7 == 0)
    s = 2j * np.pi * freq[inside]
    true = 0.3 + 0j
    for f, zeta, (a, b) in zip(part.frequency_hz, part.damping, part.numerator, strict=True):
        w = 2 * np.pi * f
        true = true + (a * s**2 + b * s) / (s**2 + 2 * zeta * w * s + w**2)
    assert np.abs(H[inside] - true).max() < 2e-3 * np.abs(true).max()


def test_noise_keeps_the_spectrum_and_not_the_phases():
    left = np.random.default_rng(0).standard_normal(1000).cumsum()
    noise = other_phases(left, np.random.default_rng(1))
    np.testing.assert_allclose(
        np.abs(np.fft.rfft(noise))[1:-1], np.abs(np.fft.rfft(left))[1:-1], rtol=1e-9
    )
    assert abs(np.corrcoef(noise, left)[0, 1]) < 0.9


def test_a_spread_is_that_of_all_hits_and_widened_by_a_tenth():
    values = {
        "a": {"1": {"damping": 0.010}, "all": {"damping": 0.012}},
        "b": {"1": None, "all": {"damping": 0.02}},
    }
    assert hammer_tables.damping_range(values, ("a",)) == (0.010, 0.012)
    assert hammer_tables.damping_range(values, ("a", "b")) == (0.010, 0.02)
    assert hammer_tables.inside(0.0091, (0.010, 0.012))
    assert not hammer_tables.inside(0.0089, (0.010, 0.012))
    assert not hammer_tables.inside(0.01, None)
    assert hammer_tables.damping_range({"a": {"1": None}}, ("a",)) is None


def test_modes_of_a_known_part_get_other_dampings():
    part = Part(np.array([900.0, 3000.0]), np.array([0.01, 0.004]), np.zeros((2, 2)), 0.0, ())
    assert part.damped(np.array([2990.0]), np.array([0.02])).damping == pytest.approx([0.01, 0.02])
