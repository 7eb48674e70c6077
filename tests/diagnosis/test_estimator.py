"""The estimator: what was found is used where it foresees, and not where it does not."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import TWO, exact_trial, lumped, recorded

from twin import mechanisms
from twin.diagnosis import estimator
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.estimator import FARTHER, Estimator, _rms, foreseeing
from twin.diagnosis.fitting import fit
from twin.diagnosis.prepare import prepare
from twin.diagnosis.refining import refined
from twin.diagnosis.search import Found
from twin.diagnosis.shown import FORESEEN, TOO_STRONG, Shown

ALL = mechanisms.vocabulary()
SOFTER = ALL["stiffness"]("storey1", -60.0)


@pytest.fixture(scope="module")
def bench():
    return Bench(TWO, tuple(exact_trial((SOFTER,), seed=s, noise=1e-3) for s in (1, 2)), "linear")


@pytest.fixture(scope="module")
def calibrated(bench):
    return fit(bench, base_hypothesis(TWO), 1e-3)


def test_what_was_found_foresees_with_its_own_slack_where_it_is_right(bench, calibrated):
    best = refined(bench, [base_hypothesis(TWO).including(SOFTER)], 1e-3)
    plain = replace(calibrated, hypothesis=base_hypothesis(TWO), slack=best.slack)
    assert foreseeing(bench, best, plain) == Estimator(best.hypothesis, best.slack)


@pytest.mark.parametrize(("share", "used"), [(0.99, False), (0.97, True)])
def test_a_gain_that_comes_and_goes_with_the_noise_is_not_trusted(
    bench, calibrated, monkeypatch, share, used
):
    best = refined(bench, [base_hypothesis(TWO).including(SOFTER)], 1e-3)
    missed = {best.hypothesis: share, calibrated.hypothesis: 1.0}
    monkeypatch.setattr(estimator, "_missed", lambda b, h, s: np.full(2, missed[h] ** 2))
    monkeypatch.setattr(estimator, "_least", lambda b, f: 2 * share**2)
    expected = best.hypothesis if used else calibrated.hypothesis
    assert foreseeing(bench, best, calibrated).hypothesis == expected


def test_what_foresees_worse_is_left_to_the_calibrated_twin(bench, calibrated):
    wrong = ALL["quadratic_stiffness"]("storey2", 40000.0)
    best = replace(calibrated, hypothesis=calibrated.hypothesis.including(wrong))
    assert foreseeing(bench, best, calibrated) == Estimator(calibrated.hypothesis, calibrated.slack)


def test_what_is_right_on_one_kind_of_test_only_is_not_trusted(bench, calibrated):
    best = refined(bench, [base_hypothesis(TWO).including(SOFTER)], 1e-3)
    first, second = bench.trials
    # the second frame is the sound one
    sound = exact_trial((), seed=2, noise=1e-3)
    louder = replace(first, u=10 * first.u, y=10 * first.y)
    mixed = replace(bench, trials=(louder, replace(second, u=sound.u, y=sound.y)))
    plain = replace(calibrated, hypothesis=base_hypothesis(TWO), slack=best.slack)
    assert foreseeing(mixed, best, plain).hypothesis == plain.hypothesis
    both = replace(bench, trials=(louder, louder))
    assert foreseeing(both, best, plain).hypothesis == best.hypothesis


def test_what_is_not_sound_must_foresee_far_better(bench, calibrated, monkeypatch):
    best = refined(bench, [base_hypothesis(TWO).including(SOFTER)], 1e-3)
    missed = {best.hypothesis: 0.9, calibrated.hypothesis: 1.0}
    monkeypatch.setattr(estimator, "_missed", lambda b, h, s: np.full(2, missed[h] ** 2))
    for floor, chosen in ((0.85, best), (0.1, calibrated)):
        monkeypatch.setattr(estimator, "_least", lambda b, f, floor=floor: 2 * floor**2)
        assert foreseeing(bench, best, calibrated).hypothesis == chosen.hypothesis
    missed[best.hypothesis] = 0.7
    assert foreseeing(bench, best, calibrated).hypothesis == best.hypothesis


def test_what_is_not_sound_must_foresee_better_in_every_recording(bench, calibrated, monkeypatch):
    best = refined(bench, [base_hypothesis(TWO).including(SOFTER)], 1e-3)
    monkeypatch.setattr(estimator, "_least", lambda b, f: 0.0)
    for second, chosen in ((0.9, best), (0.97, calibrated)):
        missed = {best.hypothesis: (0.3, second), calibrated.hypothesis: (1.0, 1.0)}
        monkeypatch.setattr(
            estimator, "_missed", lambda b, h, s, missed=missed: np.square(missed[h])
        )
        assert foreseeing(bench, best, calibrated).hypothesis == chosen.hypothesis


@pytest.mark.parametrize("sound", [True, False])
def test_what_is_not_sound_is_not_trusted_with_far_stronger_motion(
    bench, calibrated, monkeypatch, sound
):
    best = refined(bench, [base_hypothesis(TWO).including(SOFTER)], 1e-3)
    missed = {best.hypothesis: 0.5, calibrated.hypothesis: 1.0}
    monkeypatch.setattr(estimator, "_missed", lambda b, h, s: np.full(2, missed[h] ** 2))
    monkeypatch.setattr(estimator, "_least", lambda b, f: 1.0 if sound else 0.0)
    found = foreseeing(bench, best, calibrated)
    assert found.hypothesis == best.hypothesis
    strongest = np.max([np.sqrt(np.mean(t.y**2, axis=0)) for t in bench.trials], axis=0)
    trial = bench.trials[0]
    level = FARTHER * strongest / np.sqrt(np.mean(trial.y**2, axis=0))
    assert found.covers(replace(trial, y=0.99 * level * trial.y))
    assert found.covers(replace(trial, y=1.01 * level * trial.y)) is sound
    one = np.array([1.01, 0.5])  # strong in one channel only
    assert found.covers(replace(trial, y=one * level * trial.y))


def test_a_changed_part_is_the_calibrated_twin_and_foresees_as_it_is(bench, calibrated):
    assert foreseeing(bench, calibrated, calibrated) == Estimator(
        calibrated.hypothesis, calibrated.slack
    )


@pytest.mark.parametrize("helps", [True, False])
def test_the_notes_say_where_a_finding_does_not_help_to_foresee(helps):
    records = [recorded(lumped(), seed, 0.6, 6.0) for seed in (1, 2)]
    ready = prepare(lumped(), records[:1], records[1:])
    base = base_hypothesis(ready.train.model)
    nothing = fit(ready.train, base, 1e-4)
    stop = ALL["quadratic_stiffness"]("storey2", 40000.0)
    best = nothing if helps else replace(nothing, hypothesis=base.including(stop))
    found = Found(nothing, best, (), ready.train)
    shown = Shown(ready, found, nothing, seed=0)
    assert (FORESEEN in shown.notes()) is not helps


def test_a_recording_too_strong_for_a_law_is_left_to_the_calibrated_twin():
    forces = (0.6, 0.6, 1.8)
    records = [recorded(lumped(), seed, force, 6.0) for seed, force in enumerate(forces)]
    ready = prepare(lumped(), records[:1], records[1:])
    base = base_hypothesis(ready.train.model)
    nothing = fit(ready.train, base, 1e-4)
    best = replace(nothing, hypothesis=base.including(SOFTER))
    shown = Shown(ready, Found(nothing, best, (), ready.train), nothing, seed=0)
    soft, strong = shown.benches["test"].trials
    between = tuple((_rms(soft) + _rms(strong)) / 2)
    shown.estimators["explained"] = Estimator(best.hypothesis, best.slack, between)
    windows = shown._windows(shown.benches["test"])
    np.testing.assert_array_equal(windows["explained"][1], windows["calibrated"][1])
    assert np.abs(windows["explained"][0] - windows["calibrated"][0]).max() > 0.0
    assert TOO_STRONG.format(strong.name) in shown.notes()
