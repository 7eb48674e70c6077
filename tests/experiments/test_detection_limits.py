"""Detection limits: the ideal test's bar, the severity at it, and the probit curve."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtri

from experiments import detection_limits as limits
from experiments.concealed.columns import frame
from experiments.concealed.likelihood import Left
from experiments.detection_limits_probit import probit
from experiments.detection_limits_report import document
from experiments.detection_limits_rivals import names_at, nearest
from experiments.detection_limits_theory import PAIRS, Bench, needed_nats

PAIR = {pair.name: pair for pair in PAIRS}


def test_an_ideal_test_finds_nine_of_ten_effects_of_the_needed_nats():
    nats = needed_nats(41, 0.01)
    assert nats == pytest.approx(15.44, abs=0.01)
    rng = np.random.default_rng(1)
    ratio = rng.normal(nats, np.sqrt(2 * nats), 100_000)
    assert np.mean(ratio > np.log(41 / 0.01)) == pytest.approx(0.9, abs=0.005)


def test_the_probit_curve_finds_a_known_severity():
    # forty cases at every severity, their luck spread as a normal distribution is
    multiples = np.repeat((0.7, 1.0, 1.4, 2.0, 2.8), 40)
    luck = np.tile(ndtri((np.arange(40) + 0.5) / 40), 5)
    cases = {}
    for name, half in (("low", 0.9), ("high", 1.7)):
        found = np.log(multiples / half) + 0.25 * luck > 0
        cases[name] = list(zip(multiples.tolist(), found.tolist(), strict=True))
    for name, half in (("low", 0.9), ("high", 1.7)):
        one = probit(cases)[name]
        assert one.ratio == pytest.approx(half * np.exp(0.25 * 1.2816), rel=0.05)
        assert one.low < half * np.exp(0.25 * 1.2816) < one.high


@pytest.mark.parametrize("found", [True, False])
def test_cases_all_alike_still_have_a_curve(found):
    one = probit({"all": [(by, found) for by in (0.7, 1.0, 1.4, 2.0, 2.8)]})["all"]
    assert one.ratio < 1.2 if found else one.ratio > 2.8
    assert np.isfinite([one.low, one.high]).all()


@pytest.mark.parametrize("name", ["sensor_delay", "quadratic_drag"])
def test_less_noise_and_longer_recordings_lower_the_limit(name):
    def bench(noise, seconds):
        return Bench.draw(np.random.default_rng(3), noise, 1.0, seconds)

    pair, plain = PAIR[name], bench(0.005, 8.0)
    at = plain.limit(pair)
    assert plain.left(pair, at) == pytest.approx(needed_nats(), rel=0.03)
    assert bench(0.01, 8.0).limit(pair) == pytest.approx(2 * at, rel=0.1)
    assert bench(0.005, 16.0).limit(pair) < at


def test_an_ideal_test_does_not_know_that_damping_is_modal():
    # a dashpot on the upper floor is what drag looks like on the mean
    bench = Bench.draw(np.random.default_rng(3), 0.005, 1.0, 8.0)
    pair = PAIR["quadratic_drag"]
    chain = replace(bench)
    chain.__dict__["taken"] = Left(frame(bench.likelihood, bench.rehearsal.healthy))
    assert bench.limit(pair) > 1.05 * chain.limit(pair)
    spring = PAIR["cubic_stiffness"]
    assert bench.limit(spring) == pytest.approx(chain.limit(spring), rel=0.05)


def test_the_first_cases_are_one_of_every_effect_at_every_severity():
    every = limits.tasks()
    assert len({task.name for task in every}) == len(every)
    first = every[: len(PAIRS) * len(limits.MULTIPLES)]
    assert {(task.noise, task.length, task.turn) for task in first} == {(0.005, 1.0, 1)}
    assert len({(task.pair, task.multiple) for task in first}) == len(first)


@pytest.mark.parametrize("name", ["stiffness_drift", "sensor_highpass"])
def test_the_nearest_rival_is_no_farther_than_the_frame_without_an_effect(name):
    rng = np.random.default_rng(3)
    bench = Bench.draw(rng, 0.005, 1.0, 5.0)
    rival, apart = nearest(bench, rng, shapes=1)[PAIR[name].title]
    assert 0 <= apart < needed_nats()
    assert rival not in (PAIR[name].title, "-")
    assert names_at(apart) >= 1
    assert names_at(1e3) == 1


def test_the_document_holds_what_the_page_shows():
    rows = [
        {
            "mechanism": task.pair.name, "place": task.pair.place, "multiple": task.multiple,
            "noise": task.noise, "length": task.length, "limit": 1e-3, "seconds_recorded": 27.0,
            "found": task.multiple > 1.2, "first": "none", "probability": 0.9,
        }
        for task in limits.tasks()
    ]  # fmt: skip
    points = [
        {"noise": one.noise, "seconds": one.seconds, "limits": {p.title: 1e-3 for p in PAIRS}}
        for one in limits.curve_tasks()
    ]
    rivals = [{"rivals": {p.title: ("bumper storey1", 1.0) for p in PAIRS}}]
    made = json.loads(json.dumps(document(rows, points, rivals), allow_nan=False))
    assert {"text", "command", "tables", "curves"} <= set(made)
    assert all(len(row) == len(t["columns"]) for t in made["tables"] for row in t["rows"])
    for curve in made["curves"]:
        assert len(curve["x"]) == len(curve["found"]) == len(curve["limit"])
        assert any(curve["found"])
    assert all(0.9 < one["ratio"] < 2 for one in made["ratios"].values())
