"""Three twins beside the recordings: what does not help on the training ones does not predict."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis import comparison
from twin.diagnosis.beginning import added, moved_to
from twin.diagnosis.candidates import Candidate, motions, priors_of, scales_of
from twin.diagnosis.comparison import NO_HELP, compare
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.predict import placed, predictors
from twin.diagnosis.prepare import prepare
from twin.estimation.fit import fit
from twin.mechanisms.cubic_stiffness import CubicStiffness

SPRING = CubicStiffness("storey2", 3e5)


def claimed_by(rig):
    """The calibrated twin, and one with a spring that is claimed to be there, beside a rig's."""
    ready = prepare(lumped(), [recorded(rig, 1)], [recorded(rig, 2)])
    blank = Hypothesis(ready.train)
    calibrated = fit(blank)
    nothing = Explanation(blank, calibrated, calibrated.log_evidence)
    scaled = Hypothesis(
        ready.train, scales=scales_of(ready.train, motions(ready.train, blank, calibrated.z))
    )
    grown = added(scaled, Candidate((SPRING,), priors_of([SPRING])), SPRING)
    z = moved_to(grown, blank, np.zeros(len(blank.unknowns)), SPRING)
    claimed = Explanation(grown, fit(grown, z, most=1, free=np.zeros(len(z), bool)), 0.0)
    return ready, nothing, claimed


@pytest.mark.parametrize("there", [True, False])
def test_a_spring_that_is_not_there_leaves_the_prediction_to_the_calibrated_twin(there):
    ready, nothing, claimed = claimed_by(lumped(SPRING) if there else lumped())
    compared = compare(ready, nothing, nothing, claimed, 0)
    ahead = compared.fit_ahead.test
    assert (NO_HELP in compared.notes) is not there
    assert (ahead.explained == ahead.calibrated) is not there
    assert compared.fit.test.explained != compared.fit.test.calibrated


@pytest.mark.parametrize("played", [4000, 1e6])
def test_mujoco_plays_the_strongest_part_of_what_takes_too_many_steps(monkeypatch, played):
    monkeypatch.setattr(comparison, "PLAYED", played)
    ready, nothing, best = claimed_by(lumped(SPRING))
    compared = compare(ready, nothing, nothing, best, 0)
    assert not any("MuJoCo" in note for note in compared.notes)
    wrong = replace(compared.twins["explained"], mechanisms=())
    (note,) = comparison._in_mujoco(
        wrong, predictors(*placed(best.hypothesis, best.fit.z, ready.test)), best, ready
    )
    assert ("of the strongest inputs" in note) is (played == 4000)
