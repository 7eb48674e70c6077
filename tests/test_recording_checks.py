import numpy as np
import pytest

from twin.errors import RecordingError
from twin.recording import Recording
from twin.recording_checks import (
    clipped_channels,
    clipping_warnings,
    require_excitation,
    require_samples,
)

RATE = 256.0
TIME = np.arange(4096) / RATE


def of(x, name="acc_floor1"):
    return Recording.build(RATE, {name: x}, "r.csv")


def quantised(x, step):
    return np.round(x / step) * step


def noise(size=4096, seed=0):
    return np.random.default_rng(seed).standard_normal(size)


def decay(frequency=6.7):
    return np.exp(-0.3 * TIME) * np.sin(2 * np.pi * frequency * TIME)


def clip(x, limit):
    return np.clip(x, -limit, limit)


@pytest.mark.parametrize(
    "x",
    [
        clip(decay(), 0.5),
        clip(decay(), 0.5) + 0.3,
        np.minimum(decay(), 0.7),
        quantised(clip(decay(), 0.5), 0.001),
        quantised(clip(decay() + 0.02 * noise(), 0.6), 0.01),
        clip(quantised(20 * decay() + noise(), 0.3), 9.0),
        clip(np.sin(2 * np.pi * 1.9 * TIME) * np.sin(0.1 * TIME), 0.8),
    ],
)
def test_a_channel_cut_off_at_its_range_is_clipped(x):
    recording = of(x)
    assert clipped_channels(recording)["acc_floor1"] >= 3
    assert "'acc_floor1' looks clipped" in clipping_warnings(recording)[0]


def test_the_count_is_of_the_samples_at_the_limits():
    x = decay()
    at_limit = np.abs(x) >= 0.5
    found = clipped_channels(of(clip(x, 0.5)))["acc_floor1"]
    assert 0.9 * at_limit.sum() <= found <= at_limit.sum()


@pytest.mark.parametrize("step", [1e-4, 1e-2, 0.05, 0.2, 0.5, 1.0, 2.0, 5.0])
@pytest.mark.parametrize("seed", range(5))
def test_quantised_noise_is_not_clipped_however_coarse_the_steps(step, seed):
    assert clipped_channels(of(quantised(noise(seed=seed), step))) == {}


@pytest.mark.parametrize("step", [1e-4, 1e-3, 0.01, 0.03, 0.06, 0.1, 0.5])
@pytest.mark.parametrize("frequency", [0.05, 0.31, 1.0, 1.9, 6.7, 16.0])
def test_a_quantised_smooth_signal_is_not_clipped_however_slow(step, frequency):
    tone = np.sin(2 * np.pi * frequency * TIME + 0.4)
    assert clipped_channels(of(quantised(tone, step))) == {}
    assert clipped_channels(of(quantised(decay(frequency), step))) == {}


def test_a_hammer_that_rests_between_its_hits_is_not_clipped():
    force = np.zeros(4096)
    force[100:110] = 8 * np.sin(np.pi * np.arange(0.5, 10) / 10)
    hits = force + 0.5 * np.roll(force, 999)
    for rest in (0.0, -0.013, 2.5):
        assert clipped_channels(of(quantised(hits, 0.005) + rest, "force_floor1")) == {}
        assert clipped_channels(of(hits + rest, "force_floor1")) == {}


def test_signals_held_for_several_samples_are_not_clipped():
    stairs = np.repeat(noise(1024), 4)
    binary = np.where(np.repeat(noise(512), 8) > 0, 1.0, -1.0)
    assert clipped_channels(of(stairs, "force_floor1")) == {}
    assert clipped_channels(of(binary, "force_floor1")) == {}


def test_a_constant_channel_is_not_clipped():
    assert clipped_channels(of(np.full(100, 3.0))) == {}


def test_rounding_of_the_conversion_to_si_makes_no_steps():
    x = quantised(noise(), 0.5)
    rounded = np.where((np.arange(len(x)) % 2 == 0) & (x < x.max()), np.nextafter(x, 9), x)
    assert len(np.unique(rounded)) > 20
    rounded[999:1004] = x.max() + np.array([-0.5, 0, 0, 0, -0.5])
    assert clipped_channels(of(rounded)) == {}


def test_a_force_or_a_shaken_ground_excites():
    require_excitation(Recording.build(RATE, {"force_floor1": decay(), "acc_floor1": TIME}))
    require_excitation(Recording.build(RATE, {"acc_ground": decay(), "acc_floor1": TIME}))
    still = {"force_floor1": 0 * TIME, "force_floor2": decay(), "acc_floor1": TIME}
    require_excitation(Recording.build(RATE, still))


@pytest.mark.parametrize("value", [0.0, -2.5])
def test_an_input_that_does_not_vary_excites_nothing(value):
    force = Recording.build(
        RATE, {"force_floor1": 0 * TIME + value, "acc_ground": decay()}, "r.csv"
    )
    with pytest.raises(RecordingError, match=rf"^r\.csv: .*'force_floor1' is {value:g} throughout"):
        require_excitation(force)
    with pytest.raises(RecordingError, match=r"'acc_ground' is"):
        require_excitation(Recording.build(RATE, {"acc_ground": 0 * TIME + value}))


def test_a_recording_without_input_is_told_what_it_lacks_and_has():
    with pytest.raises(RecordingError, match=r"no input.*it has acc_floor1$"):
        require_excitation(of(decay()))


def test_too_few_samples_are_told_their_purpose():
    require_samples(of(TIME), 4096, "order 4")
    with pytest.raises(RecordingError, match=r"r\.csv: 4096 samples are too few for order 4"):
        require_samples(of(TIME), 4097, "order 4")
