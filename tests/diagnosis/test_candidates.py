"""What a candidate's prior takes of what it gains."""

import numpy as np
import pytest
from diagnosis_support import rng

from twin.diagnosis.candidates import Candidate
from twin.mechanisms.bumper import Bumper
from twin.mechanisms.damping import Damping
from twin.mechanisms.sensor_gain import SensorGain
from twin.mechanisms.sensor_polarity import SensorPolarity


def exact(direction, data, deviation):
    """Log evidence of a strength with a normal prior, over that without it, in unit noise."""
    information, score = direction @ direction, direction @ data
    gained = 0.5 * score**2 / (information + deviation**-2)
    return gained - 0.5 * np.log1p(deviation**2 * information)


@pytest.mark.parametrize("wide", [10.0, 100.0])
def test_the_evidence_rises_by_the_width_less_than_the_likelihood(wide):
    draw = rng(3)
    direction = draw.standard_normal(400)
    data = 0.5 * direction + draw.standard_normal(400)
    strength = float(direction @ data / (direction @ direction))
    gain = float(0.5 * (direction @ data) ** 2 / (direction @ direction))
    found = Damping("storey1", strength)
    candidate = Candidate((found,), {"change": (0.0, wide)})
    there = gain - candidate.width(found, gain)
    assert there == pytest.approx(exact(direction, data, wide), abs=0.05)


def test_what_is_known_by_its_logarithm_is_known_to_a_share_of_itself():
    stop = Bumper("storey1", 100.0, 1e-3)
    candidate = Candidate((stop,), {"stiffness": (np.log(100.0), 1.5), "gap": (0.0, 1e-3)})
    for stiffness in (1.0, 1e4):
        there = candidate.width(stop.with_values({"stiffness": stiffness}), 50.0)
        assert there == pytest.approx(0.5 * np.log1p(100.0 * 1.5**2), rel=1e-3)


def test_a_gain_is_as_strong_as_it_is_far_from_one():
    candidate = Candidate((SensorGain("acc_floor1", 1.1),), {"gain": (0.0, 0.05)})
    for gain in (1.01, 1.2):
        there = candidate.width(SensorGain("acc_floor1", gain), 50.0)
        assert there == pytest.approx(0.5 * np.log1p(100.0 * (0.05 / np.log(gain)) ** 2), rel=1e-3)


def test_what_gains_nothing_and_what_has_no_strength_take_nothing():
    candidate = Candidate((SensorPolarity("acc_floor1"),), {})
    assert candidate.width(SensorPolarity("acc_floor1"), 50.0) == 0.0
    light = Candidate((Damping("storey1", 1.0),), {"change": (0.0, 1.0)})
    assert light.width(Damping("storey1", 1.0), 0.0) == 0.0
