import math

import numpy as np
import pytest
from scipy import signal, stats

from twin.errors import ExperimentError
from twin.instruments import Instrument, auto_range

SINE = 3.0 * np.sin(np.linspace(0, 60, 4096))


def rng():
    return np.random.default_rng(7)


def test_an_ideal_instrument_changes_nothing():
    instrument = Instrument(bits=None)
    assert np.array_equal(instrument.sense(SINE, 1024.0), SINE)
    assert np.array_equal(instrument.digitise(SINE, rng()).samples, SINE)


def test_quantised_samples_are_whole_steps_and_off_by_half_a_step_at_most():
    reading = Instrument(full_scale=5.0, bits=8).digitise(SINE, rng())
    step = 10.0 / 2**8
    assert np.array_equal(reading.samples / step, np.round(reading.samples / step))
    assert 0.49 * step < np.abs(reading.samples - SINE).max() <= 0.5 * step


def test_a_converter_has_no_negative_zero():
    reading = Instrument(full_scale=1.0, bits=8).digitise(np.full(3, -1e-6), rng())
    assert not np.any(np.signbit(reading.samples))


def test_24_bits_are_the_default_over_the_auto_range():
    reading = Instrument().digitise(SINE, rng())
    assert reading.full_scale == 5.0
    assert 0 < np.abs(reading.samples - SINE).max() <= 5.0 / 2**24


@pytest.mark.parametrize(
    ("peak", "full_scale"),
    [(0.0, 1.0), (5e-324, 1.0), (0.9, 1.0), (1.0, 1.0), (1.1, 2.0), (30.0, 50.0), (6e-5, 1e-4)],
)
def test_the_auto_range_is_1_2_or_5_times_a_power_of_ten(peak, full_scale):
    assert auto_range(peak) == pytest.approx(full_scale, rel=1e-15)


def test_beyond_the_range_samples_are_clipped_and_counted():
    reading = Instrument(full_scale=2.0).digitise(SINE, rng())
    beyond = np.abs(SINE) > 2
    assert reading.clipped == np.count_nonzero(beyond) > 0
    assert reading.samples.max() == pytest.approx(2.0, rel=1e-6)
    assert reading.samples.min() == -2.0
    assert np.allclose(reading.samples[~beyond], SINE[~beyond], atol=1e-6)


def test_an_analog_output_clips_too_when_it_has_a_range():
    reading = Instrument(full_scale=2.0, bits=None).digitise(SINE, rng())
    assert reading.samples.max() == 2.0
    assert reading.clipped == np.count_nonzero(np.abs(SINE) > 2)


def test_the_noise_has_the_fraction_of_the_records_rms_that_was_asked_for():
    reading = Instrument(noise_fraction=0.01, bits=None).digitise(SINE, rng())
    expected = 0.01 * np.sqrt(np.mean(SINE**2))
    assert reading.noise_std == pytest.approx(expected, rel=1e-12)
    noise = reading.samples - SINE
    low, high = stats.chi2.interval(0.999, len(SINE))
    assert low < np.sum(noise**2) / expected**2 < high


def test_noise_in_si_units_adds_to_the_fraction_as_a_variance():
    rms = np.sqrt(np.mean(SINE**2))
    reading = Instrument(noise_fraction=0.03 / rms, noise_std=0.04).digitise(SINE, rng())
    assert reading.noise_std == pytest.approx(0.05, rel=1e-12)


def test_noise_is_white():
    noise = Instrument(noise_std=1.0, bits=None).digitise(np.zeros(20_000), rng()).samples
    for lag in (1, 2, 5):
        assert abs(np.mean(noise[lag:] * noise[:-lag])) < 4 / math.sqrt(20_000)


@pytest.mark.parametrize("frequency", [10.0, 50.0, 120.0])
def test_bandwidth_and_piezo_corner_are_one_pole_each(frequency):
    time = np.arange(40_000) / 10_000
    tone = np.exp(2j * np.pi * frequency * time)
    instrument = Instrument(bandwidth_hz=50.0, highpass_hz=20.0)
    sensed = instrument.sense(tone.real, 1e4) + 1j * instrument.sense(tone.imag, 1e4)
    expected = 1 / (1 + 1j * frequency / 50) * (1j * frequency / 20) / (1 + 1j * frequency / 20)
    # straight lines between the samples of a tone: 1 - (pi f / fs)^2 / 3 and below
    assert sensed[-1] / tone[-1] == pytest.approx(expected, rel=1e-3)


def test_a_low_pass_is_exact_for_straight_lines_between_samples():
    history = np.random.default_rng(2).standard_normal(50)
    history[0] = 0
    a = 2 * np.pi * 40.0
    _, expected, _ = signal.lsim(([a], [1, a]), history, np.arange(50) / 1000.0)
    assert np.allclose(Instrument(bandwidth_hz=40.0).sense(history, 1000.0), expected, atol=1e-13)


@pytest.mark.parametrize(
    "wrong",
    [
        {"bandwidth_hz": 0.0},
        {"highpass_hz": -1.0},
        {"full_scale": math.inf},
        {"noise_fraction": -0.1},
        {"noise_std": math.nan},
        {"bits": 1},
        {"bits": 33},
    ],
)
def test_values_no_instrument_can_have_are_refused_by_name(wrong):
    (name, value), *_ = wrong.items()
    with pytest.raises(ExperimentError, match=f"{name} of an instrument must .* not {value}"):
        Instrument(**wrong)
