"""Beside laws, small changes are followed by the linear predictor, whatever states they add."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.beginning import added, moved_to, widened
from twin.diagnosis.candidates import Candidate, motions, priors_of, scales_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.diagnosis.score_test import SMALL, ScoreTest
from twin.estimation.fit import fit
from twin.estimation.likelihood import passes
from twin.mechanisms.appendage import Appendage
from twin.mechanisms.bumper import Bumper
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.mechanisms.sensor_gain import SensorGain
from twin.mechanisms.sensor_highpass import SensorHighpass
from twin.mechanisms.sensor_hum import SensorHum
from twin.mechanisms.stiffness import Stiffness
from twin.mechanisms.unmeasured_force import UnmeasuredForce

SPRING = CubicStiffness("storey2", 3e5)


def candidate(*starts):
    return Candidate(starts, priors_of(starts))


def scored(law, scale, seconds):
    """A score test of the twin with a law that its recordings have."""
    train = [recorded(lumped(law), seed, scale=scale, seconds=seconds) for seed in (1, 2)]
    problem = prepare(lumped(), train, [recorded(lumped(law), 3)]).train
    blank = Hypothesis(problem)
    scales = scales_of(problem, motions(problem, blank, fit(blank).z))
    grown = added(replace(blank, scales=scales), candidate(law), law)
    start = moved_to(grown, blank, np.zeros(len(blank.unknowns)), law)
    return ScoreTest(grown, fit(grown, widened(grown, start)))


@pytest.fixture(scope="module")
def score():
    return scored(SPRING, 0.6, 12.0)


@pytest.fixture(scope="module")
def stopped():
    return scored(Bumper("storey2", 3000.0, 2e-3), 1.0, 6.0)


@pytest.mark.parametrize("small", [SensorGain("acc_floor1", 1.02), Stiffness("storey1", 5.0)])
def test_a_change_is_nearly_what_the_predictor_with_the_laws_inside_says(score, small):
    first = small.scaled(SMALL)
    grown = added(score.hypothesis, candidate(small), first)
    z = moved_to(grown, score.hypothesis, score.fit.z, first)
    averages = [run.averages for run in score.runs]
    exact = [(a.e - b.e).ravel() for a, b in zip(passes(grown, z, averages), score.runs,
                                                strict=True)]  # fmt: skip
    linear = [SMALL * c.ravel() for c in score._change(candidate(small), small)]
    exact, linear = np.concatenate(exact), np.concatenate(linear)
    assert np.linalg.norm(exact - linear) < 0.25 * np.linalg.norm(exact)


@pytest.mark.parametrize("more", [
    SensorHum("acc_floor1", 50.0, 0.01), SensorHighpass("acc_floor2", 0.2),
])  # fmt: skip
def test_an_instrument_with_states_of_its_own_is_screened_beside_a_law(score, more):
    (told,) = score.along([(candidate(more), more)])
    assert told is not None
    assert np.isfinite(told[0])


def test_a_force_that_nobody_measured_is_screened_beside_a_law(score):
    force = UnmeasuredForce("floor1", 5.0, 0.5, 0.01)
    assert -np.inf < score.whole(candidate(force), force) < 0.0


def test_a_short_fit_beside_laws_leaves_their_numbers_where_they_are(score):
    held = [u.name for u, free in zip(score.linear.unknowns, score.linear.free, strict=True)
            if not free]  # fmt: skip
    assert held == ["cubic_stiffness storey2 stiffness"]
    z = fit(score.linear, score.fit.z, most=2, free=score.linear.free).z
    assert np.array_equal(z[~score.linear.free], score.fit.z[~score.linear.free])


@pytest.mark.parametrize("more", [
    UnmeasuredForce("floor1", 0.01, 5.0, 5.0), Appendage("floor1", 1e-6, 6.0, 0.02),
    SensorHum("acc_floor1", 50.0, 0.01),
], ids=lambda one: one.name)  # fmt: skip
def test_blows_at_a_stop_leave_as_much_uncertain_beside_what_has_states_of_its_own(stopped, more):
    linear = stopped.linear.beside(added(stopped.hypothesis, candidate(more), more))
    z = moved_to(linear.hypothesis, stopped.hypothesis, stopped.fit.z, more)
    here, n = linear.assemble(z), len(stopped.hypothesis.problem.model.coordinates)
    grown = here.systems[0]
    assert len(grown.A) > len(stopped.linear.pushed[0])
    before, after = stopped.linear.averages[0].kicks, here.kicks[0]
    assert before
    coordinates = n + isinstance(more, Appendage)
    own = [*range(n), *range(coordinates, coordinates + n)]
    for sample, kick in before.items():
        there = after[sample][np.ix_(own, own)]
        np.testing.assert_allclose(there, kick[: 2 * n, : 2 * n], rtol=0.02, atol=1e-3 * kick.max())
    assert np.isfinite(stopped.whole(candidate(more), more))
