"""Friction's jumps: what an instrument's filter blurs is not compared."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_support import RATE, TWO, exact_trial, motion, tones
from scipy import signal

from twin import mechanisms
from twin.diagnosis import blurring
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.blurring import (
    BLURRED,
    with_recorded_outputs,
    without_any_jumps,
    without_jumps,
)
from twin.diagnosis.fitting import fit
from twin.diagnosis.stage import explained
from twin.diagnosis.trials import Trial

ALL = mechanisms.vocabulary()
FRICTION = ALL["coulomb_friction"]("storey1", 0.15, 1e-5)
OVER, SECONDS = 8, 8
NOISE = 1e-4


def rubbing(seed):
    """A trial of a frame that rubs, recorded through a filter of order six at 0.4 of the rate."""
    samples = OVER * SECONDS * round(RATE)
    force = np.zeros((samples, 2))
    force[:, 1] = tones(samples, OVER * RATE, seed, 0.5)
    rubs = lambda d, v: 0.15 * np.tanh(v / 1e-4)  # noqa: E731
    _, _, acc = motion(TWO, force, OVER * RATE, law=rubs, b=[1.0, 0.0])
    both = np.column_stack([force[:, 1:], acc])
    filtered = signal.sosfilt(signal.butter(6, 0.4 / OVER * 2, output="sos"), both, axis=0)[::OVER]
    y = filtered[:, 1:] + NOISE * np.random.default_rng(seed).standard_normal((len(filtered), 2))
    names = ("force_floor2",), ("acc_floor1", "acc_floor2")
    return Trial(
        f"seed{seed}", RATE, *names, filtered[:, :1], y, np.full(1, 1e-9), np.full(2, NOISE)
    )


@pytest.fixture(scope="module")
def bench():
    return Bench(TWO, (rubbing(1), rubbing(2)))


@pytest.fixture(scope="module")
def fitted(bench):
    return fit(bench, base_hypothesis(TWO).including(FRICTION), 1e-5)


def test_only_samples_around_jumps_change_and_what_is_left_fits_far_better(bench, fitted):
    masked, again = without_jumps(bench, fitted)
    for old, new in zip(bench.trials, masked.trials, strict=True):
        changed = np.flatnonzero(np.any(old.y != new.y, axis=1))
        assert 0.02 * old.samples < len(changed) < 0.5 * old.samples
        gaps = np.diff(changed)
        runs = np.split(changed, np.flatnonzero(gaps > 1) + 1)
        assert min(map(len, runs[1:-1])) >= 2 * BLURRED + 1
        np.testing.assert_array_equal(old.u, new.u)
        np.testing.assert_array_equal(np.flatnonzero(new.blurred), changed)
        other = np.setdiff1d(np.arange(old.samples), changed)
        np.testing.assert_array_equal(new.y[other], old.y[other])
    left = [np.mean(np.concatenate(f.innovations) ** 2) for f in (fitted, again)]
    assert left[1] < 0.25 * left[0]
    assert with_recorded_outputs(masked, bench).trials[0].y is not masked.trials[0].y
    np.testing.assert_array_equal(
        with_recorded_outputs(masked, bench).trials[1].y, bench.trials[1].y
    )


def test_laws_are_not_compared_where_friction_jumps(bench, fitted):
    masked, again = without_jumps(bench, fitted)
    blurred = masked.trials[0].blurred
    stronger = again.hypothesis.found[-1].with_values({"force": 0.3})
    other = replace(again.hypothesis, found=(stronger,))
    (rows, _) = masked.innovations([again.hypothesis, other], again.gains, again.starts)
    assert not rows[:, blurred].any()
    assert np.abs(rows[1, ~blurred]).max() > 2 * np.abs(rows[0, ~blurred]).max()


def test_the_predictions_stand_in_as_a_faulty_channel_would_have_recorded_them(bench, fitted):
    gain = ALL["sensor_gain"]("acc_floor1", 2.0)
    doubled = tuple(replace(t, y=t.y * [2.0, 1.0]) for t in bench.trials)
    twice = replace(bench, trials=doubled)
    faulty = replace(fitted, hypothesis=fitted.hypothesis.including(gain))
    one, other = (without_jumps(b, f)[0] for b, f in ((bench, fitted), (twice, faulty)))
    for plain, loud in zip(one.trials, other.trials, strict=True):
        np.testing.assert_allclose(loud.y, plain.y * [2.0, 1.0], atol=1e-12)


def test_friction_alone_is_explained_only_where_its_filter_finds_what_it_expects(bench, fitted):
    nothing_elsewhere = {"storey1": 0.0}
    quiet = replace(fitted, slack=1e-5, innovations=tuple(
        np.sqrt(np.diag(g.innovation)) * np.ones_like(e)
        for g, e in zip(fitted.gains, fitted.innovations, strict=True)
    ))  # fmt: skip
    assert explained(quiet, nothing_elsewhere, bench)
    loud = replace(quiet, innovations=tuple(3 * e for e in quiet.innovations))
    assert not explained(loud, nothing_elsewhere, bench)
    without = replace(loud, hypothesis=replace(loud.hypothesis, found=()))
    assert explained(without, nothing_elsewhere, bench)
    # what is not compared may be as it likes
    blurred = np.arange(bench.trials[0].samples) > 100
    masked = replace(bench, trials=tuple(t.with_outputs(t.y, blurred) for t in bench.trials))
    partly = replace(quiet, innovations=tuple(
        np.where(blurred[:, None], 100 * e, e) for e in quiet.innovations
    ))  # fmt: skip
    assert explained(partly, nothing_elsewhere, masked)


def test_nothing_changes_where_nothing_sticks():
    bench = Bench(TWO, (exact_trial(seed=1),))
    found = fit(bench, base_hypothesis(TWO), 1e-3)
    assert without_jumps(bench, found) == (bench, found)
    assert without_any_jumps(bench, found, [found]) == (bench, found, (found,))


@pytest.mark.parametrize(
    ("before", "after", "jumps"),
    [
        (1.0, 0.95, True),  # slides, then sticks
        (1.0, 0.98, False),  # slides on: tanh is not quite one
        (0.9, 0.75, False),  # sticks, and holds what comes
        (0.9, 0.5, True),
        (1.0, -1.0, True),
    ],
)
def test_friction_that_slid_jumps_however_little_when_it_sticks(fitted, before, after, jumps):
    force = np.full(40, after)
    force[:20] = before
    sliding = fitted.hypothesis.found[-1].with_values({"force": 0.15})
    found = replace(fitted, hypothesis=replace(fitted.hypothesis, found=(sliding,)))
    near = blurring._near_jumps(found, 0.15 * force[:, None])
    expected = np.arange(20 - BLURRED, 20 + BLURRED + 1) if jumps else []
    np.testing.assert_array_equal(np.flatnonzero(near), expected)


def test_explanations_are_compared_where_friction_jumps_in_none_of_them(bench, fitted):
    masked, current = without_jumps(bench, fitted)
    # what was left out before stays so
    early = [np.arange(t.samples) % 97 == 0 for t in bench.trials]
    trials = zip(masked.trials, early, strict=True)
    masked = replace(
        masked, trials=tuple(t.with_outputs(t.y, t.blurred | its) for t, its in trials)
    )
    heavier = ALL["mass"]("floor1", 0.05)
    moved = fit(masked, current.hypothesis.including(heavier), 1e-5, current.starts, iterations=1)
    off = replace(moved.hypothesis, found=(*current.hypothesis.found, heavier))
    other = replace(moved, hypothesis=off)
    rest, again, others = without_any_jumps(masked, current, [other])
    whole = replace(masked, trials=tuple(t.with_outputs(t.y) for t in masked.trials))
    moved = [whole.stepped([f.hypothesis], f.gains, f.starts) for f in (current, other)]
    for number, trial in enumerate(rest.trials):
        its = masked.trials[number].blurred
        own, more = (
            blurring._near_jumps(f, trials[number][2][0])
            for f, trials in zip((current, other), moved, strict=True)
        )
        assert np.any(more & ~own & ~its)
        np.testing.assert_array_equal(trial.blurred, its | own | more)
    assert again.hypothesis.labels == current.hypothesis.labels
    assert [f.hypothesis.labels for f in others] == [off.labels]
    # both are judged by the same samples
    for one in (again, *others):
        assert not one.innovations[0][rest.trials[0].blurred].any()


def test_the_best_of_those_compared_comes_first_and_what_fails_is_missing(
    bench, fitted, monkeypatch
):
    def refined(bench, starts, slack, states):
        if starts[0] == "fails":
            raise np.linalg.LinAlgError
        return SimpleNamespace(bic={"good": 1.0, "better": 0.0}.get(starts[0], 2.0))

    monkeypatch.setattr(blurring, "refined", refined)
    monkeypatch.setattr(blurring, "_left_out", lambda bench, fits: "less")
    fits = [SimpleNamespace(hypothesis=h, slack=0, starts=()) for h in ("good", "fails", "better")]
    rest, current, others = without_any_jumps(bench, fitted, fits)
    assert (rest, current.bic, [f.bic for f in others]) == ("less", 2.0, [0.0, 1.0])


def test_nothing_is_left_out_where_most_would_be(bench, fitted, monkeypatch):
    monkeypatch.setattr(blurring, "MOST", 0.01)
    assert without_jumps(bench, fitted) == (bench, fitted)
