"""Laws that are lines in the motion there was; a calibration whose tolerances are freed."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis import pipeline
from twin.diagnosis.beginning import added, moved_to, start_of
from twin.diagnosis.candidates import Candidate, motions, priors_of, scales_of
from twin.diagnosis.explanation import Explanation, says_less
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.estimation.fit import fit
from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.mechanisms.damping import Damping


@pytest.fixture(scope="module")
def blank():
    true = lumped(Damping("storey2", 2.0))
    problem = prepare(lumped(), [recorded(true, 1)], [recorded(true, 2)], None, 0.1, None).train
    h = Hypothesis(problem)
    moved = motions(problem, h, start_of(h))
    return replace(h, scales=scales_of(problem, moved))


def with_friction(h, width):
    """A set with friction whose width is a multiple of the RMS rate, where its fit would begin."""
    rate = h.around("storey2")[2]
    law = CoulombFriction("storey2", 2.0 * max(width, 1.0) * rate, width * rate)
    candidate = Candidate((law,), priors_of((law,)))
    grown = added(h, candidate, law)
    z = moved_to(grown, h, np.zeros(len(h.unknowns)), law)
    found = fit(grown, z, free=np.zeros(len(z), bool))
    return Explanation(grown, found, found.log_evidence), candidate


@pytest.mark.parametrize(("width", "less"), [(30.0, True), (0.03, False)])
def test_friction_as_wide_as_no_motion_is_fast_says_no_more_than_a_dashpot(blank, width, less):
    found, candidate = with_friction(blank, width)
    dashpot = Candidate((Damping("storey2", 1.0),), priors_of((Damping("storey2", 1.0),)))
    assert says_less(found, [candidate, dashpot]) is less
    elsewhere = Candidate((Damping("storey1", 1.0),), dashpot.priors)
    assert not says_less(found, [candidate, elsewhere]), "nothing else would say it"


def test_the_freed_calibration_begins_where_the_calibration_ended(blank, monkeypatch):
    nothing = fit(blank, start_of(blank))
    begun = {}

    def first(h, z):
        begun.update({u.name: u.value(x) for u, x in zip(h.unknowns, z, strict=True)})
        return fit(h, z, most=1)

    monkeypatch.setattr(pipeline, "fit", first)
    law, _ = with_friction(blank, 0.03)
    explanation = Explanation(blank, nothing, nothing.log_evidence)
    found = pipeline.Found(explanation, law, (), (), ())
    freed = pipeline._calibrated(found)
    assert freed.hypothesis.problem.damping_tolerance > blank.problem.damping_tolerance
    assert freed.hypothesis.problem.tolerance > blank.problem.tolerance
    moved = max(abs(z) for z in nothing.z[: len(blank.problem.base_unknowns)])
    assert moved > 1.0, "the dashpot has moved the dampings"
    assert begun == pytest.approx(nothing.values, rel=1e-9)
