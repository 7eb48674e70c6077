"""Parameters and slack in turn: a fit starts from a slack of its own where the old one hides it."""

from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_support import TWO, exact_trial

from twin import mechanisms
from twin.diagnosis import refining
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.refining import refined

SOFTER = mechanisms.vocabulary()["stiffness"]("storey1", -200.0)


def test_a_slack_that_was_needed_without_the_finding_does_not_hide_it(monkeypatch):
    bench = Bench(TWO, (exact_trial((SOFTER,), seed=1, noise=1e-3),), "linear")
    begun = []
    original = refining._begun

    def watched(bench, hypothesis, slack, states, iterations):
        begun.append(slack)
        return original(bench, hypothesis, slack, states, iterations)

    monkeypatch.setattr(refining, "_begun", watched)
    found = refined(bench, [base_hypothesis(TWO).including(SOFTER)], 0.3, rounds=0)
    assert begun[0] == 0.3
    assert min(begun) < 0.3 / refining.FAR
    assert found.slack <= 1e-3
    assert found.hypothesis.found[0].change == pytest.approx(-200.0, abs=0.5)


def test_a_neighbouring_slack_needs_no_start_of_its_own(monkeypatch):
    bench = Bench(TWO, (exact_trial((), seed=1, noise=1e-3),), "linear")
    calls = []
    original = refining._begun
    monkeypatch.setattr(refining, "_begun", lambda *a: calls.append(a[2]) or original(*a))
    refined(bench, [base_hypothesis(TWO)], 1e-4, rounds=0)
    assert len(calls) == 1


def test_friction_begins_sharp_as_well_and_nothing_else_does():
    friction = mechanisms.vocabulary()["coulomb_friction"]("storey2", 0.01, 1e-3)
    start = base_hypothesis(TWO).including(SOFTER, friction)
    sharp = refining._sharpened(start)
    assert sharp.found[0] == SOFTER
    assert sharp.found[1].values["regular_rate"] == pytest.approx(1e-6)
    assert sharp.found[1].values["force"] == 0.01
    assert refining._sharpened(base_hypothesis(TWO)) is None
    assert refining._sharpened(base_hypothesis(TWO).including(friction, SOFTER)) is None


@pytest.mark.parametrize(("blurred", "sharp"), [(10.0, 20.0), (20.0, 10.0)])
def test_of_a_blurred_and_a_sharp_start_the_better_one_is_kept(monkeypatch, blurred, sharp):
    friction = mechanisms.vocabulary()["coulomb_friction"]("storey2", 0.01, 1e-3)

    def led_to(bench, starts, *rest):
        rate = starts[-1].found[-1].values["regular_rate"]
        return SimpleNamespace(log_posterior=blurred if rate == 1e-3 else sharp)

    monkeypatch.setattr(refining, "_refined", led_to)
    found = refined(None, [base_hypothesis(TWO).including(friction)], 1e-3)
    assert found.log_posterior == 20.0


@pytest.mark.parametrize("moving", [False, True])
def test_friction_is_fitted_from_the_likelier_of_the_given_states_and_rest(monkeypatch, moving):
    """States that a model without friction asked for would hold it where it never stuck."""
    begins = np.array([0.01, -0.02, 0.1, 0.3])
    trial = exact_trial((), seed=1, noise=1e-3, start=begins if moving else None)
    bench = Bench(TWO, (trial,), "linear")
    rub = mechanisms.vocabulary()["coulomb_friction"]("storey1", 1e-6)
    rubs = base_hypothesis(TWO).including(rub)
    used = []

    def watched(bench, starts, slack, states, *_):
        used.append(states)
        return SimpleNamespace(log_posterior=0.0)

    monkeypatch.setattr(refining, "_refined", watched)
    refined(bench, [rubs], 1e-3, [begins])
    first, sharp = used
    assert sharp is None
    assert (first is None) != moving
    used.clear()
    refined(bench, [base_hypothesis(TWO)], 1e-3, [begins])
    assert used == [[begins]]  # without friction least squares find them from anywhere
