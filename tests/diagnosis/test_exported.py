"""A hypothesis in MuJoCo: the same masses, stiffnesses and dampings, and the same motion."""

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.exported import base_mechanisms, dashpots, in_mujoco, including, twin_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.predict import nrmse, predictors
from twin.diagnosis.prepare import prepare
from twin.diagnosis.problem import Problem
from twin.mechanisms.mass import Mass
from twin.mechanisms.stiffness import Stiffness
from twin.model import Twin

CHANNELS = {
    "portal_3d": (["force_floor1_x", "force_floor2_y"], ["acc_floor1_a.x", "acc_floor2_b.y"]),
    "cantilever": (["force_tip"], ["acc_tip"]),
}


@pytest.fixture(scope="module")
def moved():
    """A hypothesis whose every parameter is off the nominal one."""
    ready = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)])
    hypothesis = Hypothesis(ready.train)
    z = np.zeros(len(hypothesis.unknowns))
    z[: len(ready.train.base_unknowns)] = [3.0, -2.0, 1.0, -3.0, 0.5, -0.5]
    return ready, hypothesis, z


def test_the_twin_has_the_hypothesis_modes_and_dampings(moved):
    ready, hypothesis, z = moved
    own = ready.train.base(z)
    there = twin_of(ready.twin, hypothesis, z).linear(own.inputs, own.outputs)
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(own.M, own.K)).real)
    np.testing.assert_allclose(np.diag(there.K), squares, rtol=1e-6)
    rates = np.sort(np.linalg.eigvals(np.linalg.solve(own.M, own.R)).real)
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(there.R).real), rates, rtol=1e-6)


@pytest.mark.parametrize("name", ["portal_3d", "cantilever"])
def test_bodies_are_their_masses_and_moments_of_inertia(name):
    model = Twin.load(name).linear(*CHANNELS[name])
    parts = [b.mass * b.translation.T @ b.translation + b.spin for b in model.bodies.values()]
    np.testing.assert_allclose(sum(parts), model.M, atol=2e-3)


def test_a_heavier_body_is_heavier_throughout_in_the_exported_twin_too():
    twin = Twin.load("portal_3d")
    model = twin.linear(*CHANNELS["portal_3d"])
    problem = Problem(model, (), 256.0, 0.01, 0.3, "band_limited", np.zeros((0, len(model.M))))
    z = np.zeros(len(problem.base_unknowns))
    names = [u.name for u in problem.base_unknowns]
    z[names.index("mass floor2")] = 5.0
    wanted = problem.base(z)
    there = including(twin, base_mechanisms(problem, z)).linear(*CHANNELS["portal_3d"])
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(wanted.M, wanted.K)).real)
    np.testing.assert_allclose(np.diag(there.K), squares, rtol=2e-5)
    assert np.max(np.abs(np.diag(there.K) / np.diag(model.K) - 1)) > 0.01


def test_mujoco_moves_as_predicted(moved):
    ready, hypothesis, z = moved
    (predictor,) = predictors(hypothesis, z)
    there = in_mujoco(twin_of(ready.twin, hypothesis, z), ready.train, ready.train.recordings[0])
    assert nrmse([there[64:-64]], [predictor.from_rest()[64:-64]]) < 0.005


def test_dashpots_make_any_change_of_modal_damping(moved):
    model = moved[0].train.model
    change = np.array([[0.3, 0.1], [0.1, -0.2]])
    made = model
    for dashpot in dashpots(model, change):
        made = dashpot.edit(made)
    np.testing.assert_allclose(made.R - model.R, change, atol=1e-9)


def test_changes_of_one_kind_at_one_place_are_added_up():
    twin = including(lumped(), [Stiffness("storey1", 3.0), Stiffness("storey1", -1.0)])
    assert including(twin, [Stiffness("storey1", 1.0)]).mechanisms == (Stiffness("storey1", 3.0),)


def test_a_part_that_is_added_is_no_part_of_a_heavier_body():
    twin = including(lumped(), [Mass("floor1", 0.1, 1.0), Mass("floor1", 0.2)])
    assert twin.mechanisms == (Mass("floor1", 0.1, 1.0), Mass("floor1", 0.2))
