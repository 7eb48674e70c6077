"""Instruments as small linear systems, and what is read off a channel's samples."""

from dataclasses import replace

import numpy as np
import pytest
from mechanism_support import error
from scipy.linalg import expm
from scipy.signal import cont2discrete

from twin import mechanisms
from twin.mechanisms.sensor_drift import FLICKER, RAMP, WALK
from twin.mechanisms.shifting import later, stretched

ALL = mechanisms.vocabulary()
RATE, SAMPLES = 256.0, 4096
T = np.arange(SAMPLES) / RATE


def reading(seed=0):
    """A sum of tones up to 40 Hz that dies out at both ends, and white noise of 1 %."""
    rng = np.random.default_rng(seed)
    tones = sum(np.sin(2 * np.pi * f * T + rng.uniform(0, 7)) for f in (1.9, 6.7, 17.0, 38.0))
    return np.hanning(SAMPLES) * tones, 0.01 * rng.standard_normal(SAMPLES)


def response(instrument, frequency):
    """C (jw - A)^-1 B + D of one channel."""
    eye = np.eye(len(instrument.A))
    return np.array(
        [
            (
                instrument.C @ np.linalg.solve(2j * np.pi * f * eye - instrument.A, instrument.B)
                + instrument.D
            )[0, 0]
            for f in frequency
        ]
    )


@pytest.mark.parametrize(
    ("name", "values", "most"),
    [("sensor_highpass", (3.0,), 0.02), ("sensor_resonance", (60.0, 0.05), 1e-6)],
)
def test_a_filter_records_as_its_states_say(name, values, most):
    fault = ALL[name]("acc", *values)
    x, _ = reading()
    found = fault.distort({"acc": x}, RATE)["acc"]
    spectrum, frequency = np.fft.rfft(x), np.fft.rfftfreq(SAMPLES, 1 / RATE)
    true = np.fft.irfft(spectrum * response(fault.instrument(1.0), frequency), SAMPLES)
    assert error(found, true) < most
    assert error(x, true) > 0.1, "the test shows something"


def test_a_hum_is_the_free_motion_of_its_oscillators():
    hum = ALL["sensor_hum"]("acc", 0.3, 50.02, 1.0)
    added = hum.distort({"acc": np.zeros(600)}, RATE)["acc"]
    assert added.std() == pytest.approx(0.3, rel=0.02)
    instrument = hum.instrument(1.0)
    step = cont2discrete((instrument.A, instrument.B, instrument.C, instrument.D), 1 / RATE)[0]
    rows, state = [], np.eye(len(step))
    for _ in added:
        rows.append((instrument.C @ state)[0])
        state = step @ state
    start = np.linalg.lstsq(np.array(rows)[:100], added[:100], rcond=None)[0]
    assert error(np.array(rows)[:100] @ start, added[:100]) < 0.01
    # where a recording begins a tone is as strong as its wandering sustains it
    stationary = instrument.A @ instrument.start + instrument.start @ instrument.A.T
    np.testing.assert_allclose(stationary, -instrument.G @ instrument.G.T, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "values", "form"),
    [
        ("sensor_drift", (0.2,), {"form": WALK}),
        ("sensor_drift", (0.2,), {"form": FLICKER}),
        ("sensor_drift", (0.2,), {"form": RAMP}),
        ("sensor_unexplained", (0.3, 2.0), {}),
    ],
)
def test_a_random_error_has_the_covariance_of_its_states(name, values, form):
    fault = ALL[name]("acc", *values, **form)
    lag, instrument = 40, fault.instrument(0.0)
    zeros = {"acc": np.zeros(SAMPLES)}
    histories = [
        replace(fault, seed=float(seed)).distort(zeros, RATE)["acc"][[0, lag, 10 * lag]]
        for seed in range(400)
    ]
    # the covariance P' = A P + P A' + G G' of the states, in steps much shorter than they move in
    P, step = instrument.start.copy(), expm(instrument.A / RATE / 64)
    wanted = [instrument.C @ P @ instrument.C.T]
    for count in (lag, 9 * lag):
        for _ in range(64 * count):
            P = step @ P @ step.T + instrument.G @ instrument.G.T / RATE / 64
        wanted.append(instrument.C @ P @ instrument.C.T)
    found = np.mean(np.square(histories), axis=0)
    assert found == pytest.approx(np.ravel(wanted), rel=0.2, abs=1e-12)


def test_a_flicker_has_the_same_power_in_every_decade():
    flicker = ALL["sensor_drift"]("acc", 0.2, form=FLICKER).instrument(1.0)
    f = np.geomspace(0.03, 30, 50)
    answers = [np.linalg.solve(2j * np.pi * x * np.eye(5) - flicker.A, flicker.G) for x in f]
    density = np.array([np.linalg.norm(flicker.C @ a) ** 2 for a in answers])
    even = density * f / np.mean(density * f)
    assert np.all(np.abs(even - 1) < 0.1)


def test_a_wrong_clock_stretches_and_is_put_right():
    burst = np.exp(-(((T - 8) / 2) ** 2)) * np.sin(2 * np.pi * 31 * T)
    share = 2e-4
    shifted = T * (1 + share)
    true = np.exp(-(((shifted - 8) / 2) ** 2)) * np.sin(2 * np.pi * 31 * shifted)
    clock = ALL["clock"]("acc", share)
    found = clock.distort({"acc": burst}, RATE)
    assert error(found["acc"], true) < 1e-4 < 0.1 < error(burst, true)
    assert error(clock.undo(found, RATE)["acc"], burst) < 1e-4
    assert error(stretched(burst, RATE, 0.0), burst) == 0
    assert error(later(burst, 0.0, RATE), burst) == 0


FOUND = {
    "sensor_hum": {"amplitude": 0.03, "frequency": 50.03},
    "sensor_clipping": {"level": 1.2},
    "sensor_dropout": {"begin": 7.0, "length": 20 / RATE},
    "sensor_spikes": {"height": 5.0, "often": 0.5, "seed": 0.0},
    "sensor_quantisation": {"step": 0.05},
}


@pytest.mark.parametrize("name", FOUND)
def test_what_is_read_off_a_channel_is_found_where_it_is_and_nowhere_else(name):
    clean, noise = reading()
    fault = ALL[name]("acc").with_values({})
    fault = type(fault)("acc", **FOUND[name])
    recorded = fault.distort({"acc": clean + noise}, RATE)["acc"]
    found = type(fault).found("acc", recorded, RATE)
    assert found is not None
    for field in (key for key in FOUND[name] if key != "seed"):
        tolerance = 0.4 if field == "often" else 0.1
        assert getattr(found, field) == pytest.approx(FOUND[name][field], rel=tolerance), field
    for seed in range(5):
        sound = sum(reading(seed))
        assert type(fault).found("acc", sound, RATE) is None
        assert not ALL[name]("acc").spoiled(sound).any()


@pytest.mark.parametrize("name", ["sensor_dropout", "sensor_spikes"])
def test_what_a_fault_hides_is_what_it_changed(name):
    sound = sum(reading())
    fault = ALL[name]("acc", *FOUND[name].values())
    recorded = fault.distort({"acc": sound}, RATE)["acc"]
    changed, hidden = recorded != sound, fault.spoiled(recorded)
    assert changed.sum() > 5
    assert (hidden & changed).sum() >= 0.85 * changed.sum()
    assert (hidden & ~changed).sum() <= 1


def test_the_noise_of_rounding_is_a_twelfth_of_the_step_squared():
    fault = ALL["sensor_quantisation"]("acc", 0.05)
    sound = sum(reading())
    added = fault.distort({"acc": sound}, RATE)["acc"] - sound
    assert added.std() == pytest.approx(fault.noise(), rel=0.05)


def test_where_a_motion_is_less_than_a_step_its_readings_are_left_out():
    t = np.arange(4096) / 192.0
    blow = 20.0 * np.exp(-t) * np.sin(2 * np.pi * 21.3 * t)
    reading = np.round(blow)
    fault = ALL["sensor_quantisation"]("acc", 1.0)
    hidden = fault.spoiled(reading)
    still = np.abs(blow) < 0.5
    assert hidden[np.argmax(np.exp(-t) * 20.0 < 0.5) :].all(), "where it never leaves a step"
    assert not hidden[~still].any()
    left = (reading - blow)[~hidden]
    assert np.std(left) == pytest.approx(fault.noise(), rel=0.15)
    loud = np.round(5 * np.random.default_rng(1).standard_normal(4096))
    assert not fault.spoiled(loud).any()
    assert not ALL["sensor_quantisation"]("acc", 0.0).spoiled(np.zeros(4096)).any()


def test_what_was_high_passed_from_rest_is_taken_back():
    values = np.random.default_rng(8).standard_normal(500)
    fault = ALL["sensor_highpass"]("acc", 3.0)
    undone = fault.undo(fault.distort({"acc": values}, RATE), RATE)["acc"]
    np.testing.assert_allclose(undone, values, atol=1e-12)
