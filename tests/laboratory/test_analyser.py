import numpy as np
import pytest

from twin.errors import ExperimentError
from twin.laboratory.analyser import Analyser


def test_the_defaults_are_the_papers():
    analyser = Analyser()
    assert (analyser.sampling_hz, analyser.duration_s, analyser.samples) == (32.0, 32.0, 1024)
    gain = analyser.filter(analyser.factor()).gain(np.array([12.5, 16.0, 19.5]))
    assert gain == pytest.approx([1, 0.5, 0], abs=1e-5)


@pytest.mark.parametrize(
    ("sampling_hz", "shortest_s", "rate_hz"),
    [
        (32.0, None, 1024.0),
        (32.0, 0.008, 2016.0),
        (100.0, None, 1100.0),
        (1000.0, None, 8000.0),
        (512.0, 0.001, 16384.0),
    ],
)
def test_physics_runs_at_the_smallest_multiple_that_resolves_what_there_is(
    sampling_hz, shortest_s, rate_hz
):
    assert Analyser(sampling_hz).time_base(shortest_s).rate_hz == rate_hz


def test_the_simulation_reaches_beyond_the_record_just_as_far_as_the_filter():
    analyser = Analyser()
    base = analyser.time_base(settle_s=2.0)
    reach = analyser.filter(base.factor).reach
    assert base.first == -reach - 64 * base.factor
    assert base.index[-1] == 1023 * base.factor + reach
    assert base.index[base.running()][0] == -64 * base.factor


def test_a_record_belongs_to_the_instants_it_says():
    analyser = Analyser(sampling_hz=32.0, duration_s=4.0)
    base = analyser.time_base(settle_s=1.0)
    record = analyser.sample(np.sin(2 * np.pi * 5.0 * base.time), base)
    assert np.abs(record - np.sin(2 * np.pi * 5.0 * np.arange(128) / 32)).max() < 1e-5


def test_a_given_physics_rate_is_kept():
    assert Analyser(physics_hz=4096.0).time_base(0.008).rate_hz == 4096.0


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"duration_s": 0.0}, "duration must be a positive number of seconds, not 0"),
        ({"duration_s": 0.01}, "fewer than two samples"),
        ({"duration_s": 1e308}, "more than the 10,000,000 samples"),
        ({"sampling_hz": -1.0}, "sampling rate must be a positive"),
        ({"cut_off_hz": 17.0}, "cut-off of 17 Hz is above the Nyquist frequency 16 Hz"),
        ({"cut_off_hz": 0.0}, "cut-off frequency must be a positive"),
        ({"physics_hz": 1000.0}, "must be a multiple"),
        ({"physics_hz": 32.0}, "must be a multiple"),
    ],
)
def test_an_analyser_that_cannot_be_is_refused(wrong, message):
    with pytest.raises(ExperimentError, match=message):
        Analyser(**wrong)


def test_a_test_that_would_not_fit_the_memory_is_refused_before_it_starts():
    with pytest.raises(ExperimentError, match="physics samples one test may have"):
        Analyser(duration_s=1e5).time_base()
    with pytest.raises(ExperimentError, match="settling time must not be negative"):
        Analyser().time_base(settle_s=-1.0)
