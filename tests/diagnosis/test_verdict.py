"""Probabilities leave a share to what is in no vocabulary; rivals come from all explanations."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from twin.diagnosis.result import Finding
from twin.diagnosis.verdict import _chances, _rivals, _with_read_off, none_of_these
from twin.mechanisms import vocabulary
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.mechanisms.sensor_clipping import SensorClipping
from twin.mechanisms.sensor_unexplained import SensorUnexplained


@dataclass(frozen=True)
class Tried:
    """An explanation as far as its rivals need it."""

    labels: tuple
    log_odds: float
    fit: object = field(default=None)


A, B, C = ("a", "1"), ("b", "1"), ("c", "2")


def test_even_a_certain_explanation_is_not_printed_as_certain():
    (alone,) = _chances([0.0])
    assert alone == pytest.approx(1 - 1 / (len(vocabulary()) + 2))
    assert none_of_these() == pytest.approx(1 - alone)


def test_odds_of_three_to_one_are_probabilities_of_three_to_one():
    first, second = _chances([0.0, -np.log(3)])
    assert first == pytest.approx(3 * second)
    assert first + second == pytest.approx(1 - none_of_these())


def test_a_rival_stands_in_the_place_of_one_mechanism():
    best = Tried((A, B), 100.0)
    tried = [Tried((), 0.0), Tried((A,), 60.0), Tried((C,), 50.0), best, Tried((A, C), 97.0)]
    rivals, loss = _rivals(best, tried, 0)
    assert {r.labels: delta for r, delta in rivals} == {(): -60.0, (C,): -10.0}
    assert loss == 60.0
    rivals, loss = _rivals(best, tried, 1)
    assert {r.labels: delta for r, delta in rivals} == {(A,): -40.0, (A, C): -3.0}
    assert loss == 40.0


def test_what_stands_beside_a_mechanism_is_not_its_rival():
    best = Tried((A, B), 100.0)
    rivals, _ = _rivals(best, [Tried((), 0.0), Tried((A,), 20.0), Tried((B,), 70.0), best], 0)
    assert [(r.labels, delta) for r, delta in rivals] == [((B,), -30.0)]


def test_what_does_alone_what_two_do_is_a_rival_of_both():
    best = Tried((A, B), 100.0)
    tried = [Tried((), 0.0), Tried((A,), 60.0), Tried((C,), 90.0), best]
    rivals, _ = _rivals(best, tried, 0)
    assert {r.labels: delta for r, delta in rivals} == {(): -60.0, (C,): -10.0}


def test_what_is_left_of_a_fault_in_its_channel_comes_behind_it():
    spring, rest = (Finding(m, {}, 0.9) for m in (
        CubicStiffness("storey1", 1e5), SensorUnexplained("acc_floor1")))  # fmt: skip
    fault = Finding(SensorClipping("acc_floor1", 1.0), {}, 0.9)
    assert _with_read_off([spring, rest], [fault]) == [spring, fault, rest]
    elsewhere = Finding(SensorClipping("acc_floor2", 1.0), {}, 0.9)
    assert _with_read_off([spring, rest], [elsewhere]) == [spring, rest, elsewhere]
