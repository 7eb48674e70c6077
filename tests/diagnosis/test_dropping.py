"""A mechanism that is not needed any more goes, though the others grew up beside it."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.beginning import added, moved_to, widened
from twin.diagnosis.candidates import motions, priors_of, scales_of
from twin.diagnosis.dropping import dropped, lost
from twin.diagnosis.explanation import Explanation, converged
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.offer import offer
from twin.diagnosis.prepare import prepare
from twin.diagnosis.scales import Scales
from twin.estimation.fit import fit
from twin.estimation.likelihood import evaluate
from twin.mechanisms.bumper import Bumper
from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.mechanisms.cubic_stiffness import CubicStiffness


def test_a_force_that_stood_for_two_laws_goes_when_both_are_there():
    both = lumped(CoulombFriction("storey1", 0.4), Bumper("storey1", 15000.0, 0.0015))
    train = [recorded(both, seed, scale=2.0, seconds=5.0, noise=5e-3) for seed in (11, 12)]
    ready = prepare(lumped(), train, [recorded(both, 3, scale=2.0, seconds=8.0)])
    problem = ready.train
    blank = Hypothesis(problem)
    nothing = fit(blank, widened(blank, np.zeros(len(blank.unknowns))))
    moved = motions(problem, blank, nothing.z)
    h, z = replace(blank, scales=scales_of(problem, moved)), nothing.z
    runs = evaluate(blank, nothing.z, derivatives=False).runs
    candidates = {c.label: c for c in offer(problem, ready.kinds)(moved, runs)}
    for name, place in (("unmeasured_force", "floor1"), ("bumper", "storey1"),
                        ("coulomb_friction", "storey1")):  # fmt: skip
        candidate = candidates[name, place]
        grown = added(h, candidate, candidate.starts[0])
        z = moved_to(grown, h, z, candidate.starts[0])
        found = fit(grown, z)
        h, z = grown, found.z
    three = Explanation(h, found, found.log_evidence)
    two = dropped(three, 0, 0.0)
    assert two is not None
    assert two.labels == (("bumper", "storey1"), ("coulomb_friction", "storey1"))
    assert two.log_odds > three.log_odds
    two = converged(two)  # as the search does with what it ends with
    stop, friction = two.hypothesis.at(two.fit.z)
    values = [stop.values["gap"], friction.values["force"]]
    np.testing.assert_allclose(values, [0.0015, 0.4], rtol=0.1)


@pytest.mark.parametrize(
    ("laws", "new"),
    [
        # a stop beside friction has the friction's discrepancy, alone it has its own
        ((CubicStiffness("storey2", 1e4), Bumper("storey2", 300.0, 5e-3)),
         "discrepancy storey2 share"),
        # a port and another name of it have one discrepancy, at the first one's
        ((CubicStiffness("storey1", 1e4), CubicStiffness("floor1", 1e4)), "discrepancy floor1"),
    ],
)  # fmt: skip
def test_what_is_left_may_have_another_discrepancy(laws, new):
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    scales = Scales({law.place: (1.0, 1e-3, 0.05) for law in laws})
    both = Hypothesis(problem, laws, tuple(priors_of([law]) for law in laws), scales)
    found = fit(both, widened(both, np.zeros(len(both.unknowns))), 3)
    best = Explanation(both, found, found.log_evidence)
    assert new not in [u.name for u in both.unknowns]
    assert np.isfinite(lost(best, 0))
    one = dropped(best, 0, 0.0)
    assert one is not None
    assert one.labels == ((laws[1].name, laws[1].place),)
    assert new in [u.name for u in one.hypothesis.unknowns]
