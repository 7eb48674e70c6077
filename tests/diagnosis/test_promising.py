"""What was promising is fitted where a part of the samples does not rule it out."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.as_drawn import Begun
from twin.diagnosis.beginning import added, attempted, moved_to, start_of
from twin.diagnosis.candidates import Candidate, motions, priors_of, scales_of, surroundings
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.portion import ROUGH, on_a_part
from twin.diagnosis.prepare import prepare
from twin.diagnosis.promising import _compared, fitted
from twin.estimation.fit import fit
from twin.estimation.likelihood import evaluate
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.mechanisms.quadratic_drag import QuadraticDrag

COST = 4.0


@pytest.fixture(scope="module")
def known():
    """A calibrated twin without a spring that there is, and two things that may be missing."""
    true = lumped().including(CubicStiffness("storey2", 2e7))
    train = [recorded(true, s, scale=0.8, seconds=24.0) for s in (1, 4)]
    blank = Hypothesis(prepare(lumped(), train, [recorded(true, 2)], 0.03).train)
    found = fit(blank, start_of(blank))
    moved = motions(blank.problem, blank, found.z)
    here = replace(blank, scales=scales_of(blank.problem, moved))
    assert on_a_part(here) is not None
    begun = {}
    for kind, place in ((CubicStiffness, "storey2"), (QuadraticDrag, "floor1")):
        starts = kind.starts(place, surroundings(blank.problem, moved, place))
        grown = added(here, Candidate(starts, priors_of(starts)), starts[0])
        begun[kind.name] = Begun(grown, moved_to(grown, here, found.z, starts[0]), 100.0)
    return here, Explanation(blank, found, found.log_evidence), begun


def test_what_runs_away_on_the_part_is_fitted_no_further_however_much_it_promised(known):
    here, nothing, begun = known
    right, lost = begun["cubic_stiffness"], begun["quadratic_drag"]
    drag = [u.name.startswith("quadratic_drag") for u in lost.hypothesis.unknowns]
    part = on_a_part(lost.hypothesis)
    far = next(z for z in (np.where(drag, x, lost.z) for x in (6.0, 5.0, 4.5, 5.2, 5.7, 4.2))
               if attempted(part, z, enough=ROUGH).code == "ran away")  # fmt: skip
    lost = replace(lost, z=far, gain=10 * right.gain)
    assert list(_compared([lost, right])) == [1]
    (only,) = fitted(here, nothing, [lost, right], COST, print)
    assert only.labels == (("cubic_stiffness", "storey2"),)
    assert only.log_odds > nothing.log_odds + 100


def test_each_is_compared_with_the_inputs_that_are_likeliest_with_it(known):
    here, _, begun = known
    one = begun["cubic_stiffness"]
    held = replace(here.problem, between=("held",) * len(here.problem.between))
    h = replace(one.hypothesis, problem=held)
    found, end = _compared([replace(one, hypothesis=h)])[0]
    assert set(found.problem.between) == {"band_limited"}
    assert found.problem.recordings is held.recordings
    assert evaluate(found, end.z, False).log_likelihood > evaluate(h, end.z, False).log_likelihood
    # where these are what they were taken for nothing is made anew
    assert _compared([one])[0][0] is one.hypothesis
