"""What is smaller than what the others leave, and what there is beside it."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.as_drawn import Begun
from twin.diagnosis.beginning import added, attempted, by_name, carried, moved_to, widened
from twin.diagnosis.candidates import motions, scales_of
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.offer import offer
from twin.diagnosis.portion import on_a_part
from twin.diagnosis.prepare import prepare
from twin.diagnosis.promising import fitted
from twin.diagnosis.trifles import ends_in_a_trifle, is_trifle, no_trifle
from twin.estimation.fit import fit
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.mechanisms.damping import Damping
from twin.mechanisms.sensor_gain import SensorGain

GREAT = CubicStiffness("storey2", 2e6)
SMALL = Damping("storey1", 1e-3)
MORE = CubicStiffness("storey1", 5e5)


def explanations(*there, seconds=6.0):
    """Return explanations by the great law and the small one, and by the great law and more."""
    rig = lumped(*there)
    train = [recorded(rig, seed, scale=1.0, seconds=seconds) for seed in (11, 12)]
    ready = prepare(lumped(), train, [recorded(rig, 3, scale=1.0, seconds=6.0)])
    blank = Hypothesis(ready.train)
    nothing = fit(blank, widened(blank, np.zeros(len(blank.unknowns))))
    moved = motions(ready.train, blank, nothing.z)
    scaled = replace(blank, scales=scales_of(ready.train, moved))
    candidates = {c.label: c for c in offer(ready.train, ready.kinds)(moved, ())}
    out = []
    for last in (SMALL, MORE):
        h, z = scaled, nothing.z
        for law in (GREAT, last):
            grown = added(h, candidates[law.name, law.place], law)
            h, z = grown, moved_to(grown, h, z, law)
        held = [f"{last.name} {last.place}" in u.name for u in h.unknowns]
        found = fit(h, z, free=~np.array(held))
        out.append(Explanation(h, found, found.log_evidence))
    return out


@pytest.mark.parametrize("more", [True, False])
def test_more_than_a_trifle_is_chosen_where_it_is_there_beside_the_trifle(more):
    trifle, other = explanations(GREAT, *([MORE] if more else []))
    assert ends_in_a_trifle(trifle)
    assert not ends_in_a_trifle(other)
    assert no_trifle([trifle, other], 3.0) is (other if more else trifle)
    assert no_trifle([other, trifle], 3.0) is other


@pytest.mark.parametrize("there", [True, False])
def test_a_trifle_on_a_part_of_the_samples_is_fitted_beside_something_else_only(there):
    trifle, other = explanations(GREAT, *([MORE] if there else []), seconds=20.0)
    both = trifle.hypothesis
    h = replace(both, mechanisms=both.mechanisms[:1], priors=both.priors[:1])
    found = fit(h, carried(h, by_name(both, trifle.fit.z)))
    before = Explanation(h, found, found.log_evidence)
    assert is_trifle(both, attempted(on_a_part(both), trifle.fit.z, 0))
    assert not is_trifle(other.hypothesis, attempted(on_a_part(other.hypothesis), other.fit.z, 0))
    begun = [Begun(e.hypothesis, e.fit.z, gain) for e, gain in ((trifle, 200.0), (other, 100.0))]
    told = []
    fits = fitted(h, before, begun, 3.0, told.append)
    assert any(e.log_odds > before.log_odds for e in fits) is there
    assert [line.split()[1] for line in told if line.startswith("fitting")] == (
        ["cubic_stiffness", "damping"] if there else []
    )


@pytest.mark.parametrize(("level", "small"), [(1.0, True), (-8.0, False)])
def test_a_fault_of_an_instrument_is_a_trifle_beside_what_its_channel_reads_of_a_poor_law(
    level, small
):
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    blank = Hypothesis(problem)
    moved = motions(problem, blank, np.zeros(len(blank.unknowns)))
    spring, gain = CubicStiffness("storey2", 1e5), SensorGain("acc_floor2", 1.01)
    priors = {"stiffness": (1e5, 1.0)}, {"gain": (np.log(1.01), 1.0)}
    h = replace(blank, mechanisms=(spring, gain), priors=priors, scales=scales_of(problem, moved))
    names = [u.name for u in h.unknowns]
    z = np.zeros(len(names))
    z[names.index("discrepancy storey2")] = level
    assert is_trifle(h, fit(h, z, most=1, free=np.zeros(len(z), bool))) is small
