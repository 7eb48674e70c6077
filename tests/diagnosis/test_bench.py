"""The bench: innovations of variants side by side, and the plants that it keeps."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import TWO, exact_trial

from twin import mechanisms
from twin.diagnosis import bench as benches
from twin.diagnosis.bench import Bench, steps_for
from twin.diagnosis.fitting import gains_of
from twin.diagnosis.hypothesis import Hypothesis

ALL = mechanisms.vocabulary()
FAULTS = [ALL["sensor_gain"]("acc_floor2", gain) for gain in (1.0, 1.02, 1.02)]
BASES = [ALL["stiffness"]("storey1", change) for change in (0.0, 0.0, 5.0)]
VARIANTS = [
    Hypothesis((base,), (0.1,)).including(fault) for base, fault in zip(BASES, FAULTS, strict=True)
]


@pytest.fixture(scope="module")
def bench():
    trials = exact_trial(seed=1), replace(exact_trial(seed=2), added_mass={"floor2": 0.2})
    return Bench(TWO, trials)


def alone(bench, variant, gains):
    (one,) = zip(*bench.innovations([variant], gains), strict=True)
    return one


def test_variants_of_bases_and_faults_run_side_by_side_as_they_run_alone(bench):
    gains = gains_of(bench, VARIANTS[0], 1e-3)
    together = bench.innovations(VARIANTS, gains)
    for position, variant in enumerate(VARIANTS):
        for rows, one in zip(together, alone(bench, variant, gains), strict=True):
            np.testing.assert_allclose(rows[position], one, rtol=1e-9, atol=1e-15)
    differ = [rows[i] - rows[j] for rows in together for i, j in ((0, 1), (1, 2))]
    assert all(np.abs(d).max() > 1e-6 for d in differ), "the test shows something"


def test_plants_that_are_kept_are_those_that_were_asked_for(bench):
    first = bench._plants(VARIANTS)
    again = bench._plants(VARIANTS[::-1])
    for row, other in zip(first, again, strict=True):
        assert all(a is b for a, b in zip(row, other[::-1], strict=True))
    assert not np.allclose(first[0][0].A, first[1][0].A), "an added mass has a plant of its own"
    assert not np.allclose(first[0][0].A, first[0][2].A)
    finer = bench._plants(VARIANTS, 2)
    assert finer[0][0].step_s == pytest.approx(first[0][0].step_s / 2)


def test_no_more_plants_are_kept_than_may_be(monkeypatch, bench):
    monkeypatch.setattr(benches, "KEPT", 4)
    fresh = replace(bench)
    assert fresh._sampled == {}
    for change in range(10):
        stiffer = Hypothesis((ALL["stiffness"]("storey1", float(change)),), (0.1,))
        (row, _) = fresh._plants([stiffer])
        assert row[0].plant.model.K[0, 0] == pytest.approx(TWO.K[0, 0] + change)
        assert len(fresh._sampled) <= 6


LAWS = {
    # law -> steps a sample that suffice beside any base, error allowed (over the outputs' RMS)
    "cubic_stiffness": (ALL["cubic_stiffness"]("storey1", 2e5), 5, 1e-4),
    "hysteresis": (ALL["hysteresis"]("storey1", 100.0, 0.2), 13, 1e-4),
    "coulomb_friction": (ALL["coulomb_friction"]("storey2", 0.05), 13, 5e-3),
}


@pytest.mark.parametrize("name", LAWS)
def test_a_base_far_too_stiff_to_be_seen_asks_for_no_shorter_steps(name, monkeypatch):
    law, enough, allowed = LAWS[name]
    stiffness = 1e5 * TWO.K[1, 1]
    stiff = ALL["base_compliance"]("ground", stiffness, 0.04 * stiffness**0.5, 1.0, 1.0)
    hypothesis = Hypothesis((), (), (law, stiff))
    bench = Bench(TWO, (exact_trial((law,), seed=1),), "linear")
    plant = bench.plant(bench.trials[0], hypothesis.mechanisms)
    assert steps_for((law,), plant) == enough
    gains = gains_of(bench, hypothesis, 1e-2)
    (found,) = bench.innovations([hypothesis], gains)
    monkeypatch.setattr(benches, "steps_for", lambda *_: 500)
    (finer,) = bench.innovations([hypothesis], gains)
    scale = np.sqrt(np.mean(bench.trials[0].y ** 2))
    assert np.sqrt(np.mean((found - finer) ** 2)) < allowed * scale


def test_trials_side_by_side_give_what_they_give_one_after_the_other(monkeypatch):
    law = ALL["coulomb_friction"]("storey2", 0.05)
    trials = tuple(exact_trial((law,), seed=seed) for seed in (1, 2, 3))
    bench, hypothesis = Bench(TWO, trials), Hypothesis((), (), (law,))
    gains = gains_of(bench, hypothesis, 1e-2)
    found = []
    for threads in (1, 3):
        monkeypatch.setattr(benches, "_threads", lambda most, threads=threads: threads)
        found.append(bench.stepped([hypothesis], gains, None))
    for one, other in zip(*found, strict=True):
        for alone, together in zip(one, other, strict=True):
            np.testing.assert_array_equal(alone, together)


@pytest.mark.parametrize(("parent", "threads"), [(None, 3), ("a pool", 1)])
def test_a_worker_leaves_the_other_cores_to_the_others(monkeypatch, parent, threads):
    monkeypatch.setattr(benches.multiprocessing, "parent_process", lambda: parent)
    monkeypatch.setattr(benches.os, "cpu_count", lambda: 8)
    assert benches._threads(3) == threads
