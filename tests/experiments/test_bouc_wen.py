import numpy as np
import pytest
from scipy.integrate import solve_ivp

from experiments import bouc_wen


def test_the_integrator_agrees_with_an_adaptive_one():
    rate = 2 * bouc_wen.FINE * bouc_wen.RATE_HZ
    t = np.arange(2 * 1500 + 1) / rate

    def force(time):
        return 60 * np.sin(2 * np.pi * 33 * time) + 40 * np.sin(2 * np.pi * 70 * time)

    def slope(time, state):
        y, v, z = state
        acceleration, flow = bouc_wen._slope.py_func(y, v, z, force(time))
        return v, acceleration, flow

    moved = bouc_wen._integrated(force(t), 2 / rate)
    exact = solve_ivp(slope, (0, t[-1]), (0, 0, 0), "DOP853", t[::2], rtol=1e-10, atol=1e-14,
                      max_step=2e-5).y[0]  # fmt: skip
    # kinks of |v| cost the fixed step some digits
    assert np.abs(moved - exact).max() < 5e-5 * np.abs(exact).max()


def test_the_multisine_has_the_published_band_and_level():
    force = bouc_wen.multisine(bouc_wen.FORCE_N, 3, 3)
    period = len(force) // 3
    middle = force[period : 2 * period]
    assert np.sqrt(np.mean(middle**2)) == pytest.approx(50.0)
    spectrum = np.abs(np.fft.rfft(middle))
    f = np.fft.rfftfreq(period, 1 / (2 * bouc_wen.FINE * bouc_wen.RATE_HZ))
    inside = (f >= 5) & (f <= 150)
    assert spectrum[~inside].max() < 1e-9 * spectrum.max()
    assert spectrum[inside].min() == pytest.approx(spectrum[inside].max())
    assert force[0] == 0


def test_a_recording_is_the_response_with_its_noise_and_the_same_twice():
    force = bouc_wen.multisine(5.0, 1, 1)
    clean, noisy = (bouc_wen.respond(force, noise, 7, "one") for noise in (0.0, 1e-5))
    assert clean.samples == noisy.samples == bouc_wen.PERIOD
    assert (clean.sampling_hz, clean.names) == (750.0, ("force_floor1", "disp_floor1"))
    added = noisy.column("disp_floor1") - clean.column("disp_floor1")
    assert added.std() == pytest.approx(1e-5, rel=0.05)
    again = bouc_wen.respond(force, 1e-5, 7, "one")
    np.testing.assert_array_equal(again.data, noisy.data)


def test_the_twin_is_the_published_linear_system():
    twin = bouc_wen.linear_twin()
    model = twin.second_order()
    np.testing.assert_allclose([model.M[0, 0], model.R[0, 0], model.K[0, 0]], [2, 10, 1e5],
                               rtol=1e-6)  # fmt: skip
    assert twin.modes().natural_freq[0] == pytest.approx(35.59, abs=0.005)


def test_the_sweep_runs_through_the_published_frequencies():
    force = bouc_wen.sweep()
    rate = 2 * bouc_wen.FINE * bouc_wen.RATE_HZ
    assert len(force) / rate == pytest.approx(180.0)
    ends = (force[: int(rate)], force[-int(rate) :])
    crossings = [np.sum(np.diff(np.sign(part)) > 0) for part in ends]
    assert crossings == [pytest.approx(20, abs=1), pytest.approx(50, abs=1)]
