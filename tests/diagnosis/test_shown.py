"""Two seconds ahead: what was found is used where it foresees, and not where it does not."""

from dataclasses import replace

import pytest
from diagnosis_support import TWO, exact_trial

from twin import physics
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import fit
from twin.diagnosis.refining import refined
from twin.diagnosis.shown import _foreseeing

ALL = physics.mechanisms()
SOFTER = ALL["stiffness"]("storey1", -60.0)


@pytest.fixture(scope="module")
def bench():
    return Bench(TWO, tuple(exact_trial((SOFTER,), seed=s, noise=1e-3) for s in (1, 2)), "linear")


@pytest.fixture(scope="module")
def calibrated(bench):
    return fit(bench, base_hypothesis(TWO), 1e-3)


def test_what_was_found_foresees_with_its_own_slack_where_it_is_right(bench, calibrated):
    best = refined(bench, [base_hypothesis(TWO).including(SOFTER)], 1e-3)
    assert _foreseeing(bench, best, calibrated) == (best.hypothesis, best.slack)


def test_what_foresees_worse_is_left_to_the_calibrated_twin(bench, calibrated):
    wrong = ALL["quadratic_stiffness"]("storey2", 40000.0)
    best = replace(calibrated, hypothesis=calibrated.hypothesis.including(wrong))
    assert _foreseeing(bench, best, calibrated) == (calibrated.hypothesis, calibrated.slack)


def test_what_is_right_on_one_kind_of_test_only_is_not_trusted(bench, calibrated):
    best = refined(bench, [base_hypothesis(TWO).including(SOFTER)], 1e-3)
    first, second = bench.trials
    # the second frame is the sound one
    sound = exact_trial((), seed=2, noise=1e-3)
    louder = replace(first, u=10 * first.u, y=10 * first.y)
    mixed = replace(bench, trials=(louder, replace(second, u=sound.u, y=sound.y)))
    plain = replace(calibrated, hypothesis=base_hypothesis(TWO), slack=best.slack)
    assert _foreseeing(mixed, best, plain)[0] == plain.hypothesis
    both = replace(bench, trials=(louder, louder))
    assert _foreseeing(both, best, plain)[0] == best.hypothesis
