"""What a part of the samples decides, all of them decide as well."""

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis import dropping, portion, promising, search
from twin.diagnosis.beginning import start_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.offer import offer
from twin.diagnosis.prepare import prepare
from twin.mechanisms.bumper import Bumper
from twin.mechanisms.cubic_stiffness import CubicStiffness

NAMES = ("cubic_stiffness", "quadratic_stiffness", "bumper", "damping")


@pytest.fixture(scope="module")
def ready():
    both = lumped(CubicStiffness("storey2", 4e5), Bumper("storey1", 8000.0, 0.004))
    train = [recorded(both, seed, scale=scale, seconds=16.0) for seed, scale in ((1, 0.6), (2, 1))]
    return prepare(lumped(), train, [recorded(both, 3, scale=0.6)])


def found(ready):
    whole = offer(ready.train, ready.kinds)
    result = search.search(
        ready.train, lambda moved, runs: [c for c in whole(moved, runs) if c.label[0] in NAMES]
    )
    return result.best


@pytest.mark.parametrize(("samples", "sure"), [(512, 40.0), (900, 20.0)])
def test_two_laws_are_found_however_long_the_part_and_whatever_settles(
    ready, monkeypatch, samples, sure
):
    monkeypatch.setattr(portion, "PART", samples)
    for module in (dropping, promising):
        monkeypatch.setattr(module, "SURE", sure)
    best = found(ready)
    assert {("bumper", "storey1"), ("cubic_stiffness", "storey2")} <= set(best.labels)
    stop = next(m for m in best.hypothesis.at(best.fit.z) if m.name == "bumper")
    assert stop.values["gap"] == pytest.approx(0.004, rel=0.02)


def test_a_part_is_the_first_samples_with_the_same_unknowns(ready):
    whole = Hypothesis(ready.train)
    part = portion.on_a_part(whole)
    assert [len(r.y) for r in part.problem.recordings] == [portion.PART] * 2
    assert [u.name for u in part.unknowns] == [u.name for u in whole.unknowns]
    first = part.problem.recordings[0]
    assert np.array_equal(first.y, ready.train.recordings[0].y[: portion.PART])
    assert len(start_of(part)) == len(start_of(whole))


def test_short_recordings_have_no_part():
    ready = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)])
    assert portion.on_a_part(Hypothesis(ready.train)) is None
