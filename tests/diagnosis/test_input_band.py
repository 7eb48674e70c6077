"""Noise of an input where the input has no power, and what it is taken for."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded, rng
from scipy import signal

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.input_band import band_of, in_band, within_band
from twin.diagnosis.measured import Measured
from twin.diagnosis.plant import plant_of
from twin.diagnosis.plant_states import ORDER, band_limited
from twin.diagnosis.prepare import prepare
from twin.estimation.likelihood import evaluate
from twin.mechanisms.sensor_resonance import SensorResonance
from twin.recording import Recording

RATE = 256.0


def force(highest, seed=0, seconds=24.0):
    """Tones of equal amplitude up to a frequency and a RMS of one, (samples,)."""
    draw, samples = rng(seed), round(seconds * RATE)
    f = np.fft.rfftfreq(samples, 1 / RATE)
    inside = (f > 0.5) & (f < highest)
    x = np.fft.irfft(inside * np.exp(2j * np.pi * draw.uniform(size=len(f))), samples)
    return x / np.std(x)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e4])
def test_the_band_of_a_force_ends_where_its_noise_is_all_there_is(size):
    u = size * (force(16.0) + 0.01 * rng(1).standard_normal(round(24 * RATE)))
    assert band_of(u, RATE) == pytest.approx(16.0, abs=2.5)


def blows(seconds=24.0):
    """Blows of a hammer, a millisecond long: the spectrum falls slowly up to half the rate."""
    t, x = np.arange(round(seconds * RATE)) / RATE, 0.0
    for at in (1.0, 9.0, 17.0):
        x = x + np.exp(-0.5 * ((t - at) / 1.6e-3) ** 2)
    return x


@pytest.mark.parametrize("u", [
    np.zeros(4096),
    blows() + 1e-3 * rng(6).standard_normal(round(24 * RATE)),
    rng(2).standard_normal(4096),
    force(100.0) + 0.01 * rng(3).standard_normal(round(24 * RATE)),
    force(16.0)[:64],
])  # fmt: skip
def test_silence_noise_a_wide_band_and_a_short_record_have_none(u):
    assert band_of(u, RATE) == np.inf
    assert np.array_equal(in_band(u, np.inf, RATE), u)


def test_hum_in_a_force_belongs_to_its_band():
    t = np.arange(round(24 * RATE)) / RATE
    hum = 0.03 * np.sin(2 * np.pi * 50 * t)
    u = force(16.0) + hum + 0.01 * rng(4).standard_normal(len(t))
    assert band_of(u, RATE) == pytest.approx(50.0, abs=2.5)


def test_what_is_in_the_band_stays_as_it_was_and_what_is_above_it_goes():
    inside, noise = force(16.0), rng(5).standard_normal(round(24 * RATE))
    kept = in_band(inside, 16.0, RATE)
    assert np.std(kept - inside) < 2e-3
    f, density = signal.welch(in_band(noise, 16.0, RATE), RATE, nperseg=1024)
    assert np.max(density[f > 26.0]) < 1e-6 * np.median(density[(f > 1) & (f < 15)])


def test_the_noise_of_a_force_in_a_band_moves_the_structure_as_behind_a_low_pass():
    model = lumped().linear(("force_floor2",), ("acc_floor1", "acc_floor2"))
    f = np.array([0.5, 2.0, 5.0, 12.0, 40.0, 90.0])

    def through(system):
        s = 2j * np.pi * f
        n = len(system.A)
        states = [np.linalg.solve(x * np.eye(n) - system.A, system.W[:, 0]) for x in s]
        return np.array(states) @ system.C.T + system.V[:, 0]

    white = plant_of(model, (), (), {}).system
    banded = band_limited(plant_of(model, (), (), {}), (16.0,)).system
    _, low_pass = signal.freqs(*signal.butter(ORDER, 2 * np.pi * 16, analog=True), 2 * np.pi * f)
    np.testing.assert_allclose(through(banded), low_pass[:, None] * through(white), rtol=1e-9)
    # what the measured force does is another thing, and the same
    np.testing.assert_array_equal(banded.B[: len(white.A)], white.B)


def likelihoods(ratios, banded):
    """Log likelihoods of a mounting's damping ratios where a resonance is above the force's band.

    The truth is 0.03 at 45 Hz; the force has 12 Hz, and a noise of 2 %.
    """
    clean = recorded(lumped(), seed=7, seconds=24.0, noise=0.0)
    columns = {n: np.array(clean.column(n)) for n in clean.names}
    rings = SensorResonance("acc_floor2", 45.0, 0.03)
    columns |= rings.distort({"acc_floor2": columns["acc_floor2"]}, clean.sampling_hz)
    draw = rng(8)
    for name, level in (("acc_floor1", 2e-3), ("acc_floor2", 2e-3), ("force_floor2", 6e-3)):
        columns[name] = columns[name] + level * draw.standard_normal(clean.samples)
    spoilt = Recording.build(clean.sampling_hz, columns, "a.csv")
    problem = prepare(lumped(), [spoilt], [recorded(lumped(), seed=10)], 0.01).train
    if not banded:
        known = [replace(r, u=columns["force_floor2"][:, None], bands=())
                 for r in problem.recordings]  # fmt: skip
        problem = replace(problem, recordings=tuple(known))
    out = []
    for ratio in ratios:
        priors = {"frequency": (np.log(45.0), 1.0), "damping_ratio": (np.log(ratio), 1.0)}
        h = Hypothesis(problem, (SensorResonance("acc_floor2", 45.0, ratio),), (priors,))
        quiet = np.array([-3.0 if u.name.startswith("process") else 0.0 for u in h.unknowns])
        out.append(evaluate(h, quiet, derivatives=False).log_likelihood)
    return out


def test_a_resonance_above_the_band_of_the_force_is_not_taken_for_damped():
    true, damped = likelihoods((0.03, 0.1), banded=True)
    assert true > damped - 10.0
    # with noise that is white, whatever responds less is likelier
    true, damped = likelihoods((0.03, 0.1), banded=False)
    assert true < damped - 100.0


def test_a_record_that_begins_in_motion_loses_only_its_ends():
    long = force(16.0, seed=11, seconds=40.0)
    u = long[2000:8000] + 0.01 * rng(12).standard_normal(6000)
    measured = Measured("a", u[:, None], np.zeros((6000, 1)), np.array([0.01]), np.array([1.0]))
    kept = within_band(measured, RATE, [False])
    (band,) = kept.bands
    seen = np.isfinite(kept.y[:, 0])
    assert 6000 - 128 < seen.sum() < 6000 - 64
    assert np.max(np.abs(kept.u[seen, 0] - long[2000:8000][seen])) < 0.03
    assert band == pytest.approx(16.0, abs=2.5)
    # a command is not measured: its noise drives the structure, too
    assert within_band(measured, RATE, [True]).bands == (np.inf,)


def test_a_slow_force_leaves_most_of_a_short_record():
    t = np.arange(3000) / RATE
    u = np.sin(2 * np.pi * 0.7 * t) + 0.01 * rng(13).standard_normal(3000)
    measured = Measured("a", u[:, None], np.zeros((3000, 1)), np.array([0.01]), np.array([1.0]))
    kept = within_band(measured, RATE, [False])
    assert np.isfinite(kept.bands[0])
    assert np.isfinite(kept.y).sum() >= 7 / 8 * 3000 - 2
