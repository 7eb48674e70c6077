"""What is tried at once: what is off the drawing alone."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.candidates import Candidate, priors_of
from twin.diagnosis.drawing import odds_of, with_tolerance
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.portion import SURE
from twin.diagnosis.prepare import prepare
from twin.diagnosis.together import off_alone
from twin.estimation.fit import fit
from twin.mechanisms.mass import Mass
from twin.mechanisms.stiffness import Stiffness

COST, WIDE = 5.0, 0.1
CANDIDATES = [
    Candidate(starts, priors_of(starts))
    for starts in (
        (Mass("floor1", 0.1),), (Mass("floor2", 0.1),),
        (Stiffness("storey1", 30.0),), (Stiffness("storey2", 30.0),),
    )
]  # fmt: skip


def calibrated(twin, tolerance=None):
    """The twin within a wide tolerance, as a drawing that is off takes up what is missing."""
    problem = prepare(lumped(), [recorded(twin, 1)], [recorded(twin, 2)], tolerance, 0.005, None)
    h = Hypothesis(problem.train)
    wide, z = with_tolerance(h, np.zeros(len(h.unknowns)), WIDE)
    found = fit(wide, z)
    return Explanation(wide, found, odds_of(wide, found))


@pytest.fixture(scope="module")
def heavier():
    return calibrated(lumped().including(Mass("floor1", 0.4)))


def test_one_mass_that_a_wide_tolerance_took_up_is_found_at_a_narrow_one(heavier):
    (found,) = off_alone(heavier.hypothesis, heavier, CANDIDATES, COST)
    assert found.labels == (("mass", "floor1"),)
    assert found.hypothesis.problem.tolerance < 0.3 * WIDE
    assert found.log_odds > heavier.log_odds
    (mass,) = found.hypothesis.at(found.fit.z)
    assert mass.change == pytest.approx(0.4, rel=0.05)


def test_what_is_no_candidate_is_not_tried(heavier):
    assert not off_alone(heavier.hypothesis, heavier, CANDIDATES[1:], COST)


def test_where_the_user_says_the_tolerance_nothing_stands_out(heavier):
    h = heavier.hypothesis
    told = replace(h, problem=replace(h.problem, told=True))
    assert not off_alone(told, replace(heavier, hypothesis=told), CANDIDATES, COST)


def test_a_drawing_that_is_right_has_nothing_that_stands_out():
    quiet = calibrated(lumped())
    found = off_alone(quiet.hypothesis, quiet, CANDIDATES, COST)
    assert all(e.log_odds < quiet.log_odds + SURE for e in found)
