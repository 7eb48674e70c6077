"""Strong laws, looked for beside the nominal twin."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.as_drawn import STRONGER, as_drawn, beside_the_drawing
from twin.diagnosis.beginning import start_of
from twin.diagnosis.candidates import Candidate, motions, priors_of, scales_of, surroundings
from twin.diagnosis.drawing import far_off
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.estimation.fit import fit
from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.mechanisms.quadratic_drag import QuadraticDrag

TOLERANCE = 0.01


def calibrated(law, wide=0.3):
    """A calibration of the nominal twin to recordings of one with a law; what may be missing."""
    true = lumped().including(law)
    train, test = [recorded(true, s, scale=1.0) for s in (1, 4)], [recorded(true, 2)]
    blank = Hypothesis(prepare(lumped(), train, test, wide).train)
    found = fit(blank, start_of(blank))
    moved = motions(blank.problem, blank, found.z)
    candidates = []
    for kind in (CoulombFriction, CubicStiffness, QuadraticDrag):
        for place in ("storey1", "storey2") if kind is not QuadraticDrag else ("floor1", "floor2"):
            starts = kind.starts(place, surroundings(blank.problem, moved, place))
            candidates.append(Candidate(starts, priors_of(starts)))
    return replace(blank, scales=scales_of(blank.problem, moved)), found.z, candidates


@pytest.mark.parametrize("place", ["storey1", "storey2"])
def test_friction_that_a_calibration_stands_for_is_nearest_beside_the_drawing(place):
    law = CoulombFriction(place, 0.5, 1e-3)
    blank, z, candidates = calibrated(law)
    assert far_off(blank.problem, z)
    first, second, *_ = as_drawn(blank, z, candidates, TOLERANCE)
    found = first.start
    assert (found.name, found.place) == (law.name, law.place)
    assert first.gain > second.gain + 100
    assert law.sliding_force / STRONGER < found.values["force"] < STRONGER * law.sliding_force
    # first guesses were weaker by more than that
    there = next(c for c in candidates if c.label == (law.name, law.place))
    assert all(STRONGER * s.values["force"] < law.sliding_force for s in there.starts)
    # it begins with the drawing, as well as that is known
    begun = beside_the_drawing(blank, first, TOLERANCE)
    count = len(blank.problem.base_unknowns)
    assert begun.hypothesis.problem.tolerance == TOLERANCE
    assert not np.any(begun.z[:count])
    part = fit(begun.hypothesis, begun.z)
    assert part.log_evidence > fit(blank, z).log_evidence + 100


def test_near_its_drawing_or_with_something_found_nothing_is_looked_for():
    blank, z, candidates = calibrated(CoulombFriction("storey1", 0.5, 1e-3))
    assert as_drawn(blank, 0 * z, candidates, TOLERANCE) == []
    (law, *_), priors = candidates[0].starts, candidates[0].priors
    grown = replace(blank, mechanisms=(law,), priors=(priors,))
    assert as_drawn(grown, np.zeros(len(grown.unknowns)), candidates, TOLERANCE) == []
