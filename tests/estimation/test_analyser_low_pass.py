"""What an analyser's filter makes of forces, beside scipy's own filters on a fine grid."""

from math import factorial

import numpy as np
import pytest
from scipy.signal import butter, decimate, freqs, sosfilt

from twin.estimation.low_pass import MOMENTS, REACH, TO_POWERS, LowPass, weights

PARTS = 8
FINE = 16
"""Fine samples to a part."""


def jumps(samples, seed=1):
    """A force that changes its sign at instants between the samples, on the fine grid."""
    rng = np.random.default_rng(seed)
    t = np.arange(samples * PARTS * FINE) / (PARTS * FINE)
    return np.sign(np.sin(2 * np.pi * 0.0713 * t + 1.3 * np.sin(0.05 * t)) + 0.1 * rng.random())


def applied(row, force):
    """The weighed means over the parts around each sample whose whole window there is."""
    means = force.reshape(-1, FINE).mean(axis=1)
    windows = np.lib.stride_tricks.sliding_window_view(means, len(row))[::PARTS]
    return windows @ row


def test_of_linear_phase_it_shows_what_scipy_s_decimation_shows():
    force = jumps(200)
    shown = applied(weights(LowPass(1.0), PARTS)[0], force)
    factor = PARTS * FINE
    filtered = decimate(force, factor, ftype="fir")[REACH : REACH + len(shown)]
    unfiltered = force[::factor][REACH : REACH + len(shown)]
    inside = slice(20, -20)
    # of a jump of 2; windows of another shape differ by a hundredth of it
    assert np.sqrt(np.mean((shown - filtered)[inside] ** 2)) < 0.02
    assert np.sqrt(np.mean((unfiltered - filtered)[inside] ** 2)) > 0.2


def test_of_butterworth_it_shows_what_his_filter_shows_its_delay_taken_out():
    force, rate, cut_off, order = jumps(400), PARTS * FINE, 0.8, 8
    low_pass = LowPass(cut_off, order)
    b, a = butter(order, np.pi * cut_off, analog=True)
    w = np.array([1e-4, 2e-4])
    delay = -np.diff(np.angle(freqs(b, a, w)[1]))[0] / 1e-4  # [samples]
    seen = sosfilt(butter(order, cut_off / 2, fs=rate, output="sos"), force)
    at = (np.arange(30, 350) + delay) * rate
    filtered = np.interp(at, np.arange(len(seen)), seen)
    shown = applied(weights(low_pass, PARTS)[0], force)[30 - REACH : 350 - REACH]
    assert np.sqrt(np.mean((shown - filtered) ** 2)) < 0.03


@pytest.mark.parametrize("parts", [4, 16])
def test_a_steady_force_is_shown_and_drives_as_it_is(parts):
    shown, mean, *others = weights(LowPass(0.9), parts)
    assert shown.sum() == pytest.approx(1.0)
    assert mean.sum() == pytest.approx(1.0)
    assert [row.sum() for row in others] == pytest.approx([0.0] * (MOMENTS - 1), abs=1e-6)


@pytest.mark.parametrize("f", [0.05, 0.3])
def test_a_force_drives_by_its_legendre_coefficients_until_the_next_sample(f):
    t = (np.arange((2 * REACH + 1) * PARTS) + 0.5) / PARTS - REACH
    _, *moments = weights(LowPass(1.0), PARTS)  # the filter's ripple is a thousandth
    wave = np.sinc(f / PARTS) * np.cos(2 * np.pi * f * t + 0.4)
    x, share = np.polynomial.legendre.leggauss(12)
    true = np.cos(2 * np.pi * f * (0.5 + x / 2) + 0.4)
    polynomials = np.polynomial.legendre.legvander(x, MOMENTS - 1).T
    expected = (np.arange(MOMENTS) + 0.5) * (polynomials @ (share * true))
    assert [row @ wave for row in moments] == pytest.approx(expected, abs=1e-3)


def test_the_polynomials_hold_what_drives_a_mode_at_half_the_sampling_rate():
    # what of e^(iwt) over a sample the first of them leave to a mode at w
    x, share = np.polynomial.legendre.leggauss(20)
    wave = np.exp(0.5j * np.pi * x)
    terms = np.abs(np.polynomial.legendre.legvander(x, MOMENTS - 1).T @ (share * wave)) ** 2
    held = np.cumsum((np.arange(MOMENTS) + 0.5) * terms / 2)
    assert held[1] == pytest.approx(0.90, abs=0.005)
    assert 1 - held[-1] == pytest.approx(3e-4, abs=5e-5)


def test_these_polynomials_are_legendre_s():
    x = np.linspace(-1, 1, 7)
    powers = [((x + 1) / 2) ** k / factorial(k) for k in range(MOMENTS)]
    assert TO_POWERS @ powers == pytest.approx(np.polynomial.legendre.legvander(x, MOMENTS - 1).T)
