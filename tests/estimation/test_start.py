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
from twin.estimation.start import _climbed, _root_of_uncertain, estimated_start

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
