"""A wrong sample is told from a force that nobody measured by what it leaves."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import RATE, lumped, recorded, rng, tones

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.diagnosis.wrong_samples import without_wrong
from twin.estimation.fit import fit
from twin.recording import Recording

FINE, SAMPLES, NOISE = 8, 1536, 2e-3


def fitted(recordings):
    problem = prepare(lumped(), recordings, [recorded(lumped(), 3)]).train
    return problem, fit(Hypothesis(problem)).z


@pytest.fixture(scope="module")
def sound():
    return fitted([recorded(lumped(), 1), recorded(lumped(), 2)])


def spoilt(problem, wrong):
    """The problem with so much added to samples: (recording, sample, output, height)."""
    recordings = list(problem.recordings)
    for index, k, column, height in wrong:
        y = np.array(recordings[index].y)
        y[k, column] += height
        recordings[index] = replace(recordings[index], y=y)
    return replace(problem, recordings=tuple(recordings))


def hidden(problem):
    return {
        (i, int(k), int(c))
        for i, r in enumerate(problem.recordings)
        for k, c in np.argwhere(np.isnan(r.y))
    }


def test_nothing_is_left_out_of_sound_recordings(sound):
    problem, z = sound
    assert without_wrong(Hypothesis(problem), z) == (problem, (), 0.0)


@pytest.mark.parametrize("height", [30 * NOISE, 300 * NOISE])
def test_wrong_samples_are_left_out_where_a_record_begins_and_beside_each_other(sound, height):
    problem, z = sound
    wrong = [(0, 20, 0, height), (0, 700, 1, -height), (0, 709, 0, height), (1, 1500, 1, height)]
    found, faults, cost = without_wrong(Hypothesis(spoilt(problem, wrong)), z)
    assert hidden(found) == {(i, k, c) for i, k, c, _ in wrong}
    assert {(f.recording, f.fault.place): f.hidden for f in faults} == {
        (problem.recordings[0].name, "acc_floor1"): 2,
        (problem.recordings[0].name, "acc_floor2"): 1,
        (problem.recordings[1].name, "acc_floor2"): 1,
    }
    assert all(f.fault.height == pytest.approx(height, rel=0.2) for f in faults)
    assert cost > 4 * np.log(SAMPLES)


@pytest.mark.parametrize("lasts", [1, 2])
def test_blows_that_nobody_measured_are_no_wrong_samples(lasts):
    struck = []
    for seed in (1, 2):
        force = tones(SAMPLES * FINE, RATE * FINE, seed, 0.3)
        blows = np.zeros(SAMPLES * FINE)
        for at in rng(seed).integers(200, SAMPLES - 200, 8) * FINE:
            width = np.arange(lasts * FINE)
            blows[at : at + len(width)] += 2.0 * np.sin(np.pi * width / len(width))
        moved = lumped().simulate(
            {"force_floor2": force, "force_floor1": blows}, RATE * FINE, SAMPLES * FINE
        )
        columns = {"force_floor2": force[::FINE]}
        for name in ("acc_floor1", "acc_floor2"):
            noise = NOISE * rng(seed).standard_normal(SAMPLES)
            columns[name] = moved.column(name)[::FINE] + noise
        struck.append(Recording.build(RATE, columns, f"seed{seed}.csv"))
    problem, z = fitted(struck)
    found, faults, _ = without_wrong(Hypothesis(problem), z)
    assert hidden(found) == hidden(problem)
    assert faults == ()
