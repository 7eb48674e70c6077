"""What is strong, looked for beside the nominal twin."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import RATE, lumped, recorded

from twin.diagnosis.as_drawn import STRONGER, as_drawn, beside_the_drawing, seen_in_simulation
from twin.diagnosis.beginning import start_of
from twin.diagnosis.candidates import Candidate, motions, priors_of, scales_of, surroundings
from twin.diagnosis.drawing import far_off
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.diagnosis.search import _promising
from twin.estimation.fit import fit
from twin.mechanisms.appendage import Appendage
from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.mechanisms.mass import Mass
from twin.mechanisms.quadratic_drag import QuadraticDrag
from twin.mechanisms.sensor_delay import SensorDelay
from twin.mechanisms.sensor_drift import SensorDrift
from twin.mechanisms.sensor_gain import SensorGain
from twin.mechanisms.sensor_highpass import SensorHighpass
from twin.mechanisms.sensor_hum import SensorHum
from twin.mechanisms.sensor_unexplained import SensorUnexplained
from twin.mechanisms.stiffness import Stiffness
from twin.mechanisms.unmeasured_force import UnmeasuredForce

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


def far(problem):
    """A hypothesis and values of a twin that has moved far from its drawing."""
    blank = Hypothesis(problem)
    z = np.zeros(len(blank.unknowns))
    z[: len(problem.stiffnesses)] = 0.2 / problem.tolerance
    assert far_off(problem, z)
    return blank, z


def among(problem, blank, z, kinds):
    """Candidates of some kinds at every place of each."""
    moved = motions(problem, blank, np.zeros(len(z)))
    out = []
    for kind, places in kinds:
        for place in places:
            starts = kind.starts(place, surroundings(problem, moved, place))
            out.append(Candidate(starts, priors_of(starts)))
    return out


CHANNELS, FLOORS = ("acc_floor1", "acc_floor2"), ("floor1", "floor2")
KINDS = ((SensorDelay, CHANNELS), (SensorGain, CHANNELS), (Mass, FLOORS),
         (Appendage, FLOORS), (Stiffness, ("storey1", "storey2")))  # fmt: skip


def late(recording, fault):
    columns = fault.distort({n: recording.column(n) for n in recording.names}, RATE)
    return replace(recording, data=np.column_stack([columns[n] for n in recording.names]))


@pytest.mark.parametrize(
    "missing",
    [SensorDelay("acc_floor2", 0.4 / RATE), Mass("floor1", 0.08), Appendage("floor2", 0.05, 4.0)],
    ids=lambda m: m.name,
)
def test_what_is_linear_is_nearest_with_its_own_numbers(missing):
    fault = isinstance(missing, SensorDelay)
    true = lumped() if fault else lumped().including(missing)
    train = [recorded(true, s, scale=1.0) for s in (1, 4)]
    if fault:
        train = [late(r, missing) for r in train]
    problem = prepare(lumped(), train, [recorded(lumped(), 2)], 0.3).train
    blank, z = far(problem)
    first, second, *_ = as_drawn(blank, z, among(problem, blank, z, KINDS), TOLERANCE)
    assert first.candidate.label == (missing.name, missing.place)
    assert first.gain > second.gain + 100
    name = next(iter(missing.parameters))
    # no first guess is as near: its own numbers were fitted
    assert first.start.values[name] == pytest.approx(missing.values[name], rel=0.02)
    guesses = [s.values[name] for s in first.candidate.starts]
    assert min(abs(g / missing.values[name] - 1) for g in guesses) > 0.02


def test_what_no_simulation_shows_is_passed_over():
    by_chance = (
        SensorHum("acc_floor1"),
        SensorDrift("acc_floor1"),
        SensorUnexplained("acc_floor1"),
    )
    assert not any(
        seen_in_simulation(mechanism) for mechanism in (UnmeasuredForce("floor1"), *by_chance)
    )
    seen = (SensorDelay("acc_floor1"), SensorGain("acc_floor1"), SensorHighpass("acc_floor1"),
            Mass("floor1"), CoulombFriction("storey1"))  # fmt: skip
    assert all(seen_in_simulation(mechanism) for mechanism in seen)
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)], 0.3).train
    blank, z = far(problem)
    candidates = among(problem, blank, z, ((UnmeasuredForce, FLOORS),))
    assert as_drawn(blank, z, candidates, TOLERANCE) == []


def test_a_channel_of_which_nothing_was_measured_is_passed_over():
    missing = Mass("floor1", 0.08)
    train = [recorded(lumped().including(missing), s, scale=1.0) for s in (1, 4)]
    problem = prepare(lumped(), train, [recorded(lumped(), 2)], 0.3).train
    y = np.array(problem.recordings[0].y)
    y[:, problem.model.outputs.index("acc_floor2")] = np.nan
    first = replace(problem.recordings[0], y=y)
    problem = replace(problem, recordings=(first, *problem.recordings[1:]))
    blank, z = far(problem)
    found, *_ = as_drawn(blank, z, among(problem, blank, z, KINDS[2:]), TOLERANCE)
    assert found.candidate.label == ("mass", "floor1")
    assert found.start.values["change"] == pytest.approx(0.08, rel=0.02)


def test_what_brings_the_twin_back_to_its_drawing_is_all_that_a_step_asks():
    h, z, candidates = calibrated(CoulombFriction("storey1", 0.5, 1e-3))
    found = fit(h, z, 0)
    best = Explanation(h, found, found.log_evidence)
    moved = motions(h.problem, h, found.z, found.averages)
    only = [c for c in candidates if c.label == ("coulomb_friction", "storey1")]
    told = []
    fits, scores = _promising(best, h, only, moved, 1.0, TOLERANCE, told.append)
    assert [e.labels for e in fits] == [(("coulomb_friction", "storey1"),)]
    # no slopes: what beside the drawing came nearer
    assert scores == as_drawn(h, found.z, only, TOLERANCE)
    # far from its drawing without it, near with it
    assert far_off(h.problem, found.z)
    assert not far_off(h.problem, fits[0].fit.z)
