"""The state before the first sample, integrated out by Laplace's method."""

from dataclasses import replace

import numpy as np
import pytest
from estimation_support import FRICTION, TwoMasses, shaken

from twin.estimation.averages import averages_at
from twin.estimation.density import density
from twin.estimation.kalman import gains
from twin.estimation.law_averages import LawAverages
from twin.estimation.likelihood import evaluate
from twin.estimation.passing import run
from twin.estimation.sensitivities import plants_of
from twin.estimation.start import ROUGHLY, _climbed, _root_of_uncertain, estimated_start

PORTS = ((1.0, 0.0),)


class Corners(TwoMasses):
    """The two masses with laws that have corners, which a filter of no analyser smears."""

    blurred = True

    def blur(self, forces, system):
        return np.zeros((len(forces), len(system.C)))


def log_likelihood(here, trial, plant, noise, x0=None):
    gain = gains(plant, noise)
    e = run(here, trial, plant, gain, x0=x0).e
    return density(e, trial.y, gain.innovation, None).value


def test_of_a_linear_model_it_is_exact():
    trial = shaken(300, 5, (), ())
    model = TwoMasses((trial,), (), ())
    here = model.assemble(np.zeros(len(model.unknowns)))
    (plant,), noise = plants_of(here, model), here.noises[0]
    start = estimated_start(here, trial, plant, noise, LawAverages())
    known = replace(noise, start=0 * noise.start)
    beside = log_likelihood(here, trial, plant, known, start.state)
    # the gains settle at a thousandth of the innovations' covariance
    assert beside + start.odds == pytest.approx(log_likelihood(here, trial, plant, noise), abs=0.05)
    assert start.odds < -1.0


def in_motion():
    """Return friction that slides from the first sample on, and the rate there."""
    trial = shaken(600, 31, (FRICTION,), PORTS)
    later = 150
    cut = replace(trial, u=trial.u[later:], between=trial.between[later:], y=trial.y[later:])
    model = Corners((cut,), (FRICTION,), PORTS)
    whole = Corners((trial,), (FRICTION,), PORTS)
    return model, evaluate(whole, np.zeros(len(whole.unknowns)), derivatives=False), later


def test_friction_begins_with_the_motion_that_there_is():
    model, whole, later = in_motion()
    (found,) = evaluate(model, np.zeros(len(model.unknowns)), derivatives=False).runs
    rate = found.sampled.system.rate[0]
    before = whole.runs[0].x[later : later + 20] @ rate
    assert found.averages.start is not None
    assert found.x[:20] @ rate == pytest.approx(before, abs=0.15 * np.max(np.abs(before)))


def test_what_it_begins_with_follows_from_values_nearby():
    model, _, _ = in_motion()
    z = np.zeros(len(model.unknowns))
    here = model.assemble(z)
    plants = plants_of(here, model)
    fresh = averages_at(model, here, plants, 0)
    again = averages_at(model, here, plants, 0, fresh)
    assert again.start == pytest.approx(fresh.start, rel=0.02, abs=1e-4)
    assert again.start_odds == pytest.approx(fresh.start_odds, abs=0.2)


def test_a_step_that_is_tried_begins_along_slopes_that_are_known():
    model, _, _ = in_motion()
    z = np.zeros(len(model.unknowns))
    here = model.assemble(z)
    fresh = averages_at(model, here, plants_of(here, model), 0)
    z[[u.role == "law" for u in model.unknowns]] = 0.3
    moved = model.assemble(z)
    plants = plants_of(moved, model)
    whole = averages_at(model, moved, plants, 0, fresh)
    tried = averages_at(model, moved, plants, 0, fresh, roughly=True)
    assert tried.start_slopes is fresh.start_slopes
    assert whole.start_slopes is not fresh.start_slopes
    went = np.linalg.norm(whole.start - fresh.start)
    assert went > 0
    assert np.linalg.norm(tried.start - whole.start) < 0.2 * went


def test_values_that_are_compared_begin_within_a_nat_of_where_they_would():
    model, _, _ = in_motion()
    z = np.zeros(len(model.unknowns))
    here = model.assemble(z)
    plants = plants_of(here, model)
    values = []
    for roughly in (False, True):
        averages = [averages_at(model, here, plants, 0, roughly=roughly)]
        values.append(evaluate(model, z, derivatives=False, averages=averages).log_likelihood)
    assert values[1] == pytest.approx(values[0], abs=ROUGHLY)
    assert values[1] <= values[0] + 0.05


def test_of_laws_that_all_but_run_away_nothing_tells_for_a_state():
    steep = np.full((2, 2), 1e100)  # slopes beyond all bounds: rounding leaves no curvature

    def passed(s, sloped):
        return 1.0, np.ones(2), steep

    start, _ = _climbed(passed, np.eye(2), 5, None, 0.01)
    assert np.array_equal(start.state, np.zeros(2))
    assert start.odds == -np.inf


def test_states_that_are_known_have_no_directions():
    states = np.array([[2.0, 0.0, 0.5], [0.0, 0.0, 0.0], [0.5, 0.0, 1.0]])
    root = _root_of_uncertain(states)
    assert root.shape == (3, 2)
    assert root @ root.T == pytest.approx(states)


def test_a_state_that_a_twin_with_less_began_with_leads_where_none_leads():
    model, _, _ = in_motion()
    here = model.assemble(np.zeros(len(model.unknowns)))
    plants = plants_of(here, model)
    fresh = averages_at(model, here, plants, 0)
    n = plants[0].system.coordinates
    for known in (fresh.start[: 2 * n], -fresh.start[: 2 * n], None):  # that of a wrong twin, too
        again = averages_at(model, replace(here, begun=(known,)), plants, 0)
        assert again.start == pytest.approx(fresh.start, rel=0.02, abs=1e-4)
        assert again.start_odds == pytest.approx(fresh.start_odds, abs=0.2)


def test_what_the_structure_did_not_have_then_is_at_rest():
    model, _, _ = in_motion()
    here = model.assemble(np.zeros(len(model.unknowns)))
    system = here.systems[0]
    more = replace(system, A=np.zeros((7, 7)), coordinates=3)
    assert here.near(0, system) is None
    begun = replace(here, begun=(None, np.array([1.0, 2.0, 3.0, 4.0])))
    assert begun.near(0, system) is None
    assert np.array_equal(begun.near(1, more), [1.0, 2.0, 0.0, 3.0, 4.0, 0.0, 0.0])
