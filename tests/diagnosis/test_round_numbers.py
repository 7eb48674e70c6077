"""Where nobody says how well a shaken structure's numbers are known, its frequencies tell."""

from dataclasses import replace

import numpy as np
import pytest
from shaken_support import chain, ground, shaken

from twin.diagnosis import pipeline, round_numbers
from twin.diagnosis.prepare import prepare
from twin.diagnosis.round_numbers import has_round_numbers

RATE = 32.0
MASSES, STIFFNESSES, DAMPERS = [1.4, 0.9, 1.1], [240.0, 6e3, 5e3], [0.8, 7.0, 7.0]


@pytest.fixture(scope="module")
def recordings():
    return [
        shaken(MASSES, STIFFNESSES, DAMPERS, ground(30, RATE, seed, 1.0), RATE, f"{seed}.csv")
        for seed in (1, 2)
    ]


def prepared(recordings, tolerance):
    train, test = recordings
    return prepare(chain(MASSES, STIFFNESSES), [train], [test], tolerance, 1.0)


@pytest.mark.parametrize(
    ("factors", "expected"),
    [((1.0, 1.0, 1.0), False), ((0.5, 1.0, 1.0), False), ((1.0, 2.0, 1.0), False),
     ((0.5, 2.0, 1.0), True), ((0.7, 0.5, 1.8), True)],
)  # fmt: skip
def test_one_local_change_makes_no_round_numbers(recordings, monkeypatch, factors, expected):
    problem = replace(prepared(recordings, 1.0).train, sampling_hz=200.0)
    K = problem.model.K + sum(
        (factor - 1) * k * np.outer(row, row)
        for factor, (_, row, k) in zip(factors, problem.stiffnesses, strict=True)
    )
    found = replace(problem.model, K=K)
    monkeypatch.setattr(round_numbers, "calibrated_model", lambda _: found)
    assert has_round_numbers(problem) == expected


def test_the_frequencies_are_those_of_the_recordings(recordings):
    assert not has_round_numbers(prepared(recordings, 1.0).train)


def test_a_structure_with_round_numbers_is_judged_by_its_simulation(recordings, monkeypatch):
    ready, anything = (prepared(recordings, tolerance) for tolerance in (None, 1.0))
    assert ready.shaken
    for off in (False, True):
        monkeypatch.setattr(pipeline, "has_round_numbers", lambda _, off=off: off)
        chosen = pipeline._as_known(ready, anything)
        assert chosen.simulated == off
        assert any("taken as unknown" in note for note in chosen.notes) == off
