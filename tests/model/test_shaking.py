"""A ground that is shaken along any axis, against the same in relative coordinates."""

import numpy as np
import pytest
from test_linear import PLANE, PLANE_REST, inertial, mjcf

from twin.errors import ModelError
from twin.mechanisms.damping import Damping
from twin.model import Twin
from twin.model.free_run import free_run


@pytest.mark.parametrize("axes", ["x", "y", "xy", "xyz"])
def test_a_model_without_a_ground_of_its_own_is_shaken_as_its_equations_say(axes):
    twin = Twin(mjcf(PLANE, PLANE_REST))
    names = [f"acc_ground.{axis}" for axis in axes if axis != "z"]
    sensors = ["A1.x", "A1.y", "spin.z"]
    model = twin.linear(names, sensors)
    rng = np.random.default_rng(2)
    ground = {axis: 1e-3 * rng.standard_normal(400) for axis in axes}
    u = np.column_stack([ground[axis] for axis in axes if axis != "z"])
    found = free_run(model, u, 200)
    motion = twin.simulate({}, 200, 400, ground_acceleration=ground)
    for index, name in enumerate(sensors):
        true = motion.column(name)
        assert np.abs(found[:, index] - true).max() < 1e-4 * np.abs(true).max(), name


def test_an_axis_that_rests_changes_nothing_of_another():
    twin = Twin.load("two_storey_lumped")
    ground = np.random.default_rng(3).standard_normal(300)
    own = twin.simulate({}, 100, 300, ground_acceleration=ground).columns
    wrapped = twin.simulate({}, 100, 300, {"x": ground, "z": np.zeros(300)})
    for name in ("acc_floor1", "acc_floor2", "acc_ground", "disp_floor2"):
        difference = np.abs(own[name] - wrapped.column(name)).max()
        assert difference < 1e-6 * np.abs(own[name]).max()


@pytest.mark.parametrize("again", [False, True], ids=["as it is", "read from its file"])
def test_a_dashpot_to_the_world_is_shaken_with_it(again):
    twin = Twin.load("two_storey_lumped").including(Damping("floor2", 8.0))
    twin = Twin(twin.mjcf_of()) if again else twin
    sensors = ["acc_floor1", "acc_floor2"]
    ground = np.random.default_rng(3).standard_normal(600)
    found = free_run(twin.linear(["acc_ground"], sensors), ground[:, None], 200)
    bare = Twin.load("two_storey_lumped").linear(["acc_ground"], sensors)
    without = free_run(bare, ground[:, None], 200)
    motion = twin.simulate({}, 200, 600, ground_acceleration=ground)
    for index, name in enumerate(sensors):
        true = motion.column(name)
        assert np.abs(found[:, index] - true).max() < 1e-4 * np.abs(true).max(), name
        assert np.abs(without[:, index] - true).max() > 1e-2 * np.abs(true).max()


def test_a_ground_shaken_upwards_is_felt_by_an_accelerometer_on_it():
    up = np.linspace(0, 1, 50)
    motion = Twin.load("two_storey").simulate({}, 100, 50, ground_acceleration={"z": up})
    np.testing.assert_allclose(motion.columns["acc_ground.z"], 9.81 + up, atol=1e-7)


def test_a_structure_tied_to_the_world_follows_the_ground():
    body = (
        '<body name="bar" pos="1 0 0"><joint type="slide" axis="1 0 0"/>'
        f'<joint type="slide" axis="0 1 0" stiffness="500" damping="3"/>{inertial(1)}'
        '<site name="s"/></body>'
    )
    rest = '<sensor><accelerometer name="a" site="s"/></sensor>'
    tie = '<equality><weld body1="bar" solref="0.001 1" solimp=".9999 .9999 .1 .5 2"/></equality>'
    ramp = {"x": np.linspace(0, 1, 100)}
    free = Twin(mjcf(body, rest)).simulate({}, 500, 100, ground_acceleration=ramp)
    tied = Twin(mjcf(body, rest + tie)).simulate({}, 500, 100, ground_acceleration=ramp)
    assert np.abs(free.column("a")).max() < 1e-9  # it slides
    np.testing.assert_allclose(tied.column("a"), ramp["x"], atol=0.02)


def test_what_floats_has_no_ground():
    body = f'<body name="ship"><freejoint name="sea"/>{inertial(1)}</body>'
    twin = Twin(mjcf(body, gravity=0), "mine")
    with pytest.raises(ModelError, match="mine: joint 'sea' is free"):
        twin.simulate({}, 100, 5, ground_acceleration={"y": np.zeros(5)})
    with pytest.raises(ModelError, match="no axis 'up'"):
        Twin.load("two_storey").simulate({}, 100, 5, ground_acceleration={"up": np.zeros(5)})
