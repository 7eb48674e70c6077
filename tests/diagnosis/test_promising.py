"""What was promising is fitted as far as it may come near; a twin may come back to its drawing."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.as_drawn import Begun
from twin.diagnosis.beginning import added, moved_to, start_of
from twin.diagnosis.candidates import Candidate, motions, priors_of, scales_of, surroundings
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.portion import on_a_part
from twin.diagnosis.prepare import prepare
from twin.diagnosis.promising import _compared, fitted, on_the_part
from twin.diagnosis.search import _back
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


def test_what_cannot_come_near_what_is_ahead_is_not_fitted(known):
    here, nothing, begun = known
    told = []
    right, *_ = fitted(here, nothing, [begun["cubic_stiffness"]], COST, told.append)
    assert right.labels == (("cubic_stiffness", "storey2"),)
    assert right.log_odds > nothing.log_odds + 100
    assert on_the_part(right) > on_the_part(nothing) + 20
    wrong = begun["quadratic_drag"]
    assert fitted(here, nothing, [wrong], COST, told.append)  # alone it may stand for the spring
    fits = sum("fitting" in line for line in told)
    assert fitted(here, nothing, [wrong], COST, told.append, right) == []
    assert sum("fitting" in line for line in told) == fits


def test_a_twin_is_back_at_its_drawing_when_it_is_likelier_and_has_not_moved(known):
    _, nothing, _ = known
    z = np.zeros(len(nothing.fit.z))
    far = z.copy()
    far[: len(nothing.hypothesis.problem.stiffnesses)] = 0.1 / nothing.hypothesis.problem.tolerance
    at = {
        name: replace(nothing, fit=replace(nothing.fit, z=values), log_odds=nothing.log_odds + odds)
        for name, values, odds in (("near", z, 5.0), ("nearer", z, 9.0), ("far", far, 99.0),
                                   ("behind", z, -1.0))
    }  # fmt: skip
    assert _back(nothing, [at["near"], at["far"], at["nearer"], at["behind"]]) is at["nearer"]
    assert _back(nothing, [at["far"], at["behind"]]) is None


def test_each_is_compared_with_the_inputs_that_are_likeliest_with_it(known):
    here, _, begun = known
    one = begun["cubic_stiffness"]
    held = replace(here.problem, between=("held",) * len(here.problem.between))
    h = replace(one.hypothesis, problem=held)
    found, z = _compared([replace(one, hypothesis=h)], -np.inf)[0]
    assert set(found.problem.between) == {"band_limited"}
    assert found.problem.recordings is held.recordings
    assert evaluate(found, z, False).log_likelihood > evaluate(h, z, False).log_likelihood
    # where these are what they were taken for nothing is made anew
    assert _compared([one], -np.inf)[0][0] is one.hypothesis
