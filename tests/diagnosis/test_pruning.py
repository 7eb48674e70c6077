"""Backward elimination: what the rest explains is dropped, what is needed stays."""

import numpy as np
import pytest
from diagnosis_support import TWO, exact_trial

from twin import mechanisms
from twin.diagnosis import pruning
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.pruning import pruned
from twin.diagnosis.refining import refined
from twin.diagnosis.stage import DECISIVE, Stage

ALL = mechanisms.vocabulary()
SOFTER = ALL["stiffness"]("storey1", -60.0)
LOUDER = ALL["sensor_gain"]("acc_floor2", 1.05)
NEEDLESS = ALL["sensor_delay"]("acc_floor1", 1e-5)


@pytest.fixture(scope="module")
def bench():
    """A storey that is softer, under an accelerometer that reads too much."""
    trial = exact_trial((SOFTER,), seed=1)
    gain = np.array([1.0, LOUDER.gain])
    return Bench(TWO, (trial.with_outputs(trial.y * gain),), "linear")


def fitted(bench, *found):
    return refined(bench, [base_hypothesis(TWO).including(*found)], 1e-3)


def stages_of(best, count):
    return [Stage(best, {"storey1": float(i)}, (), (best,)) for i in range(count)]


def test_what_the_rest_explains_is_dropped_with_its_stage(bench):
    best = fitted(bench, SOFTER, NEEDLESS, LOUDER)
    stages = stages_of(best, 4)
    left, kept, lost = pruned(bench, best, stages, 1e-3)
    assert left.hypothesis.labels == (("stiffness", "storey1"), ("sensor_gain", "acc_floor2"))
    assert kept[:2] == (stages[0], stages[2])
    assert kept[2].where == stages[3].where
    assert kept[2].before is left, "nothing more was found after what is left"
    assert len(lost) == 2
    assert min(lost) > 10 * DECISIVE
    assert left.bic < best.bic


def test_what_is_needed_stays_and_its_worth_is_told(bench):
    best = fitted(bench, SOFTER, LOUDER)
    stages = stages_of(best, 2)
    left, kept, lost = pruned(bench, best, stages, 1e-3)
    assert left is best
    assert kept == tuple(stages)
    assert lost[1] == pytest.approx(fitted(bench, SOFTER).bic - best.bic, rel=0.05)
    assert min(lost) > 10 * DECISIVE


def test_a_single_finding_is_never_dropped(bench):
    best = fitted(bench, NEEDLESS)
    stages = stages_of(best, 1)
    assert pruned(bench, best, stages, 1e-3) == (best, tuple(stages), (np.inf,))


def test_what_cannot_be_fitted_without_stays(monkeypatch, bench):
    best = fitted(bench, NEEDLESS, SOFTER)

    def fails(*_, **__):
        raise np.linalg.LinAlgError

    monkeypatch.setattr(pruning, "refined", fails)
    left, _, lost = pruned(bench, best, stages_of(best, 2), 1e-3)
    assert left is best
    assert lost == (np.inf, np.inf)
