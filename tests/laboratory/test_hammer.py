import numpy as np
import pytest

from twin.errors import ExperimentError
from twin.laboratory.analyser import Analyser
from twin.laboratory.hammer import Hammer, half_sine

RNG = np.random.default_rng(0)


def test_the_impulse_of_a_half_sine_is_two_peak_width_over_pi():
    time = np.linspace(0, 1, 200_001)
    pulse = half_sine(time, 0.3, 0.008, 20.0)
    assert np.trapezoid(pulse, time) == pytest.approx(2 * 20 * 0.008 / np.pi, rel=1e-5)
    assert pulse.max() == pytest.approx(20.0, rel=1e-6)
    assert np.all(pulse[(time < 0.3) | (time > 0.308)] == 0)


@pytest.mark.parametrize("width", [0.002, 0.008, 0.02])
@pytest.mark.parametrize("delay", [0.5, 0.50021])
def test_the_straight_lines_of_the_simulated_force_keep_the_impulse_within_a_third_percent(
    width, delay
):
    hammer = Hammer(width_s=width, delay_s=delay)
    base = Analyser().time_base(hammer.shortest_s)
    force = hammer.history(base, RNG)
    assert np.sum(force) / base.rate_hz == pytest.approx(hammer.impulse, rel=3.3e-3)


def test_nothing_happens_before_the_delay():
    base = Analyser().time_base(0.008)
    force = Hammer(delay_s=0.5).history(base, RNG)
    assert np.all(force[base.time <= 0.5] == 0)
    assert np.all(force[(base.time > 0.5) & (base.time < 0.508)] > 0)


def test_a_double_hit_is_two_pulses_of_the_given_distance_and_strength():
    base = Analyser().time_base(0.008)
    single = Hammer().history(base, RNG)
    double = Hammer(bounce_after_s=0.0625, bounce_strength=0.25).history(base, RNG)
    shift = round(0.0625 * base.rate_hz)
    assert np.allclose(double[shift:] - single[shift:], 0.25 * single[:-shift], atol=1e-9)
    assert np.array_equal(double[:shift], single[:shift])


def test_a_hammer_hits_from_the_other_side_too():
    base = Analyser().time_base(0.008)
    assert np.array_equal(
        Hammer(peak_n=-5.0).history(base, RNG), -Hammer(peak_n=5.0).history(base, RNG)
    )


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"width_s": -0.008}, "width of a blow must be a positive number of seconds, not -0.008"),
        ({"peak_n": 0.0}, "peak of a blow must not be zero"),
        ({"peak_n": np.nan}, "peak of a blow must not be zero"),
        ({"delay_s": -1.0}, "delay of a blow must not be negative"),
        ({"bounce_after_s": 0.004}, "begins before the first ends"),
        ({"bounce_after_s": 0.04, "bounce_strength": 0.0}, "strength of the second blow"),
    ],
)
def test_a_blow_that_cannot_be_is_refused(wrong, message):
    with pytest.raises(ExperimentError, match=message):
        Hammer(**wrong)


def test_a_blow_after_the_records_end_is_refused():
    base = Analyser(duration_s=1.0).time_base()
    with pytest.raises(ExperimentError, match="record, which is 1 s long"):
        Hammer(delay_s=0.995).history(base, RNG)
