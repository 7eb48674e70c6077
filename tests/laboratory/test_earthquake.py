import numpy as np
import pytest

from twin.errors import ExperimentError
from twin.laboratory.analyser import Analyser
from twin.laboratory.earthquake import Earthquake

RNG = np.random.default_rng(0)
TIME = np.arange(0, 10, 0.02)
QUAKE = np.sin(np.pi * TIME / 10) ** 2 * np.sin(2 * np.pi * 3.1 * TIME)


def test_the_table_follows_the_band_limited_signal_through_the_samples():
    base = Analyser(duration_s=12.0).time_base()
    history = Earthquake(QUAKE, 50.0, delay_s=1.0).history(base, RNG)
    t = base.time - 1.0
    expected = np.sin(np.pi * t / 10) ** 2 * np.sin(2 * np.pi * 3.1 * t)
    expected[(t < 0) | (t > TIME[-1])] = 0
    assert np.abs(history - expected).max() < 1e-4


def test_the_table_rests_before_and_after():
    base = Analyser(duration_s=12.0).time_base()
    history = Earthquake(QUAKE, 50.0, delay_s=1.0).history(base, RNG)
    assert np.all(history[(base.time < 1) | (base.time > 11)] == 0)


def test_the_peak_of_the_samples_is_scaled():
    base = Analyser(duration_s=12.0).time_base()
    history = Earthquake(QUAKE, 50.0, peak=0.3).history(base, RNG)
    unscaled = Earthquake(QUAKE, 50.0).history(base, RNG)
    assert np.allclose(history, unscaled * 0.3 / np.abs(QUAKE).max(), rtol=1e-12)


def test_a_motion_longer_than_the_record_is_cut_by_the_record():
    base = Analyser(duration_s=5.0).time_base()
    history = Earthquake(QUAKE, 50.0).history(base, RNG)
    assert len(history) == base.samples
    assert np.any(history[base.time > 5])


def test_a_ground_motion_drives_the_ground():
    quake = Earthquake(QUAKE, 50.0)
    assert quake.moves_the_ground
    assert quake.duration_s == pytest.approx(9.98)


@pytest.mark.parametrize(
    ("acceleration", "options", "message"),
    [
        (QUAKE, {"rate_hz": 0.0}, "sampling rate of Kobe must be a positive"),
        (QUAKE, {"peak": -1.0}, "peak acceleration must be a positive"),
        (QUAKE, {"delay_s": -1.0}, "delay of a ground motion"),
        ([1.0], {}, "Kobe: a ground motion needs at least two samples"),
        ([1.0, np.nan], {}, "Kobe: the acceleration has samples that are not finite"),
        ([0.0, 0.0], {}, "Kobe: the acceleration is zero throughout"),
    ],
)
def test_a_ground_motion_that_cannot_be_is_refused(acceleration, options, message):
    with pytest.raises(ExperimentError, match=message):
        Earthquake(acceleration, **{"rate_hz": 50.0, "name": "Kobe", **options})
