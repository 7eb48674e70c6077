"""What was nearly as likely is fitted beside what was found later."""

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.beginning import start_of
from twin.diagnosis.candidates import Candidate, priors_of
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.moving import Rival, elsewhere, in_their_place, rivals_of
from twin.diagnosis.portion import SURE
from twin.diagnosis.prepare import prepare
from twin.estimation.fit import fit
from twin.mechanisms.mass import Mass
from twin.mechanisms.sensor_gain import SensorGain
from twin.mechanisms.stiffness import Stiffness

COST = 4.0
HEAVIER, SOFTER = Mass("floor1", 0.1), Stiffness("storey1", -50.0)
GAIN = SensorGain("acc_floor2", 1.05)


def explanation(problem, *mechanisms):
    h = Hypothesis(problem, mechanisms, tuple(priors_of([m]) for m in mechanisms))
    found = fit(h, start_of(h))
    return Explanation(h, found, found.log_evidence - COST * len(mechanisms))


@pytest.fixture(scope="module")
def problem():
    heavier = lumped().including(HEAVIER)
    return prepare(
        lumped(), [recorded(heavier, 1)], [recorded(heavier, 2)], None, 0.005, None
    ).train


@pytest.fixture(scope="module")
def wrong(problem):
    return explanation(problem, SOFTER, GAIN)


@pytest.fixture(scope="module")
def rival(problem):
    return explanation(problem, HEAVIER)


def test_the_rival_takes_the_place_of_what_was_chosen(wrong, rival):
    (found,) = in_their_place(wrong, [Rival(("stiffness", "storey1"), rival)], COST)
    assert found.labels == (("mass", "floor1"), ("sensor_gain", "acc_floor2"))
    assert found.log_odds > wrong.log_odds + SURE
    mass = found.hypothesis.at(found.fit.z)[0]
    assert mass.change == pytest.approx(0.1, rel=0.05)
    assert np.all(np.isfinite(found.fit.z))


def test_a_mechanism_is_found_elsewhere_though_it_was_put_at_the_wrong_place(problem, rival):
    there = explanation(problem, Mass("floor2", 0.1))
    starts = (HEAVIER,)
    (found,) = elsewhere(there, [Candidate(starts, priors_of(starts))], COST)
    assert found.labels == rival.labels
    assert found.log_odds > there.log_odds + SURE
    assert elsewhere(there, [], COST) == []


def test_a_rival_that_a_part_of_the_samples_settles_is_not_fitted_to_all(monkeypatch):
    heavier = lumped().including(HEAVIER)
    recordings = [recorded(heavier, seed, seconds=24.0) for seed in (1, 2)]
    problem = prepare(lumped(), recordings[:1], recordings[1:], None, 0.005, None).train
    right, wrong = explanation(problem, HEAVIER, GAIN), explanation(problem, SOFTER)
    tried = []
    monkeypatch.setattr("twin.diagnosis.moving.explained", lambda h, *rest: tried.append(h))
    assert in_their_place(right, [Rival(("mass", "floor1"), wrong)], COST) == []
    assert tried == []


def test_there_is_none_where_what_was_chosen_is_gone_or_stands_alone(wrong, rival):
    assert in_their_place(wrong, [Rival(("damping", "storey2"), rival)], COST) == []
    assert in_their_place(rival, [Rival(("mass", "floor1"), wrong)], COST) == []


def test_rivals_are_those_beside_the_same_others_that_nothing_settles(wrong, rival):
    best = Explanation(wrong.hypothesis, wrong.fit, 100.0)
    near = Explanation(rival.hypothesis, rival.fit, 99.0)
    first = Explanation(explanation_of_one(wrong), wrong.fit, 100.0)
    assert rivals_of(first, [near]) == [Rival(("stiffness", "storey1"), near)]
    assert rivals_of(first, [Explanation(near.hypothesis, near.fit, 100.0 - SURE - 1)]) == []
    assert rivals_of(best, [near]) == [], "it has not the same others"
    assert rivals_of(first, [first]) == []


def explanation_of_one(explanation):
    h = explanation.hypothesis
    return Hypothesis(h.problem, h.mechanisms[:1], h.priors[:1])
