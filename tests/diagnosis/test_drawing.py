"""The tolerance of a drawing, found from recordings where the user says none."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.drawing import LEAST, at_its_tolerance, far_off, in_words, odds_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.pipeline import diagnose
from twin.diagnosis.prepare import prepare
from twin.estimation.fit import fit
from twin.mechanisms.mass import Mass
from twin.mechanisms.stiffness import Stiffness


def built(*shares):
    """The frame with stiffnesses and masses off by shares: storey1, storey2, floor1, floor2."""
    model = lumped().second_order()
    springs = -model.K[0, 1] + np.array([model.K[0, 0] + model.K[0, 1], 0.0])
    masses = np.diag(model.M)
    return lumped(
        Stiffness("storey1", shares[0] * springs[0]),
        Stiffness("storey2", shares[1] * springs[1]),
        Mass("floor1", shares[2] * masses[0]),
        Mass("floor2", shares[3] * masses[1]),
    )


def fitted(twin, tolerance=None):
    train, test = [recorded(twin, 1), recorded(twin, 2)], [recorded(twin, 3)]
    hypothesis = Hypothesis(prepare(lumped(), train, test, tolerance).train)
    return hypothesis, fit(hypothesis, np.zeros(len(hypothesis.unknowns)))


@pytest.fixture(scope="module")
def loose():
    return fitted(built(0.09, -0.07, 0.11, -0.08))


def test_what_is_off_throughout_widens_the_tolerance(loose):
    hypothesis, _ = at_its_tolerance(*loose)
    assert 0.05 < hypothesis.problem.tolerance < 0.2
    assert f"{100 * hypothesis.problem.tolerance:.2g} %" in in_words(hypothesis.problem)


def test_one_mass_that_stands_out_does_not():
    hypothesis, _ = at_its_tolerance(*fitted(built(0.002, -0.003, 0.25, 0.001)))
    assert hypothesis.problem.tolerance < 2.5 * LEAST


def test_a_calibration_is_far_off_where_it_moves_the_twin_by_more_than_a_drawing_errs(loose):
    hypothesis, found = loose
    assert far_off(hypothesis.problem, found.z)
    assert not far_off(hypothesis.problem, 0 * found.z)
    near, close = fitted(built(0.004, -0.003, 0.005, 0.001))
    assert not far_off(near.problem, close.z)
    # it is the masses and stiffnesses that count, whatever their prior deviation is
    wider = replace(near.problem, tolerance=10 * near.problem.tolerance)
    assert far_off(wider, np.ones(len(close.z)))


def test_what_the_user_says_stands(loose):
    told = replace(loose[0], problem=replace(loose[0].problem, told=True))
    assert at_its_tolerance(told, loose[1])[0] is told
    assert odds_of(told, loose[1]) == loose[1].log_evidence


def test_the_evidence_of_another_tolerance_is_that_of_a_fit_with_it(loose):
    """In closed form from one fit, against fits with both: Laplace's method throughout."""
    wider, found = at_its_tolerance(*loose)
    assert found.log_evidence - loose[1].log_evidence > 20
    assert odds_of(*loose) == pytest.approx(odds_of(wider, found), abs=0.3)


def test_a_frame_off_its_drawing_by_a_tenth_is_consistent_without_a_word_from_the_user():
    twin = built(0.09, -0.07, 0.11, -0.08)
    train = [recorded(twin, 1), recorded(twin, 2, scale=0.15)]
    found = diagnose(lumped(), train, [recorded(twin, 3)])
    assert found.verdict == "consistent", found.findings
    assert any("taken as known to" in note for note in found.notes)


def test_a_fit_that_ran_away_gains_nothing_by_another_tolerance(loose):
    hypothesis, found = loose
    count = 4
    far = np.where(np.arange(len(found.z)) < count, 60.0, found.z)
    astray = replace(found, z=far, log_evidence=-1e4, code="ran away")
    assert odds_of(hypothesis, astray) == -1e4
    assert odds_of(hypothesis, replace(astray, code="converged")) > -0.9e4, "and it would"
