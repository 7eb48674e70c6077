"""Mechanisms at joints, tendons, bodies and sites: a frame in three dimensions, a beam, a drive."""

from functools import cache

import mujoco
import numpy as np
import pytest
from mechanism_support import RATE, error, push, readings

from twin import mechanisms
from twin.errors import ModelError
from twin.mechanisms.edits import add_point_mass
from twin.mechanisms.rest import Rest
from twin.model import Twin
from twin.model.free_run import free_run

ALL = mechanisms.vocabulary()
FREQUENCY = np.array([0.3, 1.1, 2.9, 4.0, 5.5, 9.0, 14.0, 30.0])
CHANNELS = {
    "portal_3d": (
        ["force_floor2_x", "force_floor2_y", "force_floor1_x"],
        ["acc_floor1_a.x", "acc_floor1_a.y", "acc_floor2_b.x", "acc_floor2_b.y"],
    ),
    "cantilever": (["force_tip", "force_mid"], ["acc_low", "acc_mid", "acc_tip"]),
    "two_storey": (["force_floor2"], ["acc_floor1", "acc_floor2"]),
    "drive": (["force"], ["position"]),
}
CHANGES = [
    ("portal_3d", "stiffness", "storey1_column1_x", -100.0),
    ("portal_3d", "stiffness", "storey2_rz", 20.0),
    ("portal_3d", "stiffness", "storey2_y", -200.0),
    ("portal_3d", "stiffness", "acc_floor2_a.y", 100.0),
    ("portal_3d", "stiffness", "floor2.x-floor1.x", 100.0),
    ("portal_3d", "damping", "storey1_y", 10.0),
    ("portal_3d", "damping", "floor2.rz", 1.0),
    ("portal_3d", "mass", "floor1", 0.3),
    ("portal_3d", "mass", "acc_floor2_b", 0.3),
    ("portal_3d", "mass", "acc_floor2_b", -0.1),
    ("portal_3d", "appendage", "floor2.y", 0.1, 4.0, 0.02),
    ("portal_3d", "appendage", "floor2.rz", 0.01, 5.0, 0.02),
    ("portal_3d", "p_delta", "storey1_x", 1.0, 0.312),
    ("portal_3d", "base_compliance", "ground.x", 5e4, 20.0, 5.0),
    ("portal_3d", "base_compliance", "ground.y", 5e4, 20.0, 5.0),
    ("cantilever", "stiffness", "hinge3", -5.0),
    ("cantilever", "stiffness", "link5-link2", 100.0),
    ("cantilever", "damping", "acc_mid", 0.05),
    ("cantilever", "mass", "link5", 0.02),
    ("cantilever", "mass", "acc_tip", 0.02),
    ("cantilever", "appendage", "link8", 0.01, 5.0, 0.02),
    ("cantilever", "appendage", "link8.ry", 1e-4, 5.0, 0.02),
    ("cantilever", "p_delta", "hinge1", 0.5, 0.3),
    ("cantilever", "base_compliance", "ground", 5e3, 2.0, 0.5),
    ("two_storey", "stiffness", "storey1", -50.0),
    ("two_storey", "mass", "floor1", 0.3),
    ("two_storey", "damping", "floor2", 0.3),
    ("two_storey", "base_compliance", "ground", 5e4, 10.0, 2.5),
    ("drive", "mass", "carriage", 3.0),
    ("portal_3d", "mass", "floor2", 0.2, 1.0),
    ("cantilever", "mass", "link9", 0.002, 1.0),
    ("drive", "damping", "carriage", 30.0),
    ("drive", "base_compliance", "ground", 5e6, 10.0, 20.0),
]
LAWS = [
    # model, mechanism, place, values, push [N], steps a sample, error of the readings
    ("portal_3d", "cubic_stiffness", "storey1_column2_x", (4e9,), 0.5, 2, 5e-3),
    ("portal_3d", "quadratic_drag", "floor2.y", (500.0,), 0.5, 2, 5e-3),
    ("portal_3d", "bumper", "storey2_rz", (300.0, 5e-5), 0.5, 5, 5e-3),
    ("portal_3d", "clearance", "storey2_x", (1000.0, 2e-5, 1000.0), 0.5, 5, 5e-3),
    ("portal_3d", "coulomb_friction", "storey1_x", (0.1, 1e-6), 0.5, 20, 0.03),
    ("portal_3d", "coulomb_friction", "storey2_rz", (0.005, 1e-6), 0.5, 20, 0.03),
    ("portal_3d", "hysteresis", "storey2_column3_y", (800.0, 0.02, 20.0, 800.0), 0.5, 5, 0.03),
    ("portal_3d", "stiffness_drift", "storey2_y", (-0.2, 5000.0), 0.5, 2, 5e-3),
    ("cantilever", "cubic_stiffness", "hinge1", (2e6,), 0.02, 8, 5e-3),
    ("cantilever", "bumper", "acc_mid", (300.0, 1e-4), 0.02, 8, 5e-3),
    ("drive", "pendulum_friction", "slide", (10.0, 1e-4), 60.0, 10, 1e-3),
    ("drive", "coulomb_friction", "carriage", (10.0, 1e-4), 60.0, 10, 1e-3),
]


@cache
def load(name):
    return Twin.load(name)


@cache
def linear(name):
    return load(name).linear(*CHANNELS[name])


def response(model):
    return model.state_space().frequency_response(FREQUENCY)


@pytest.mark.parametrize("case", CHANGES, ids=lambda case: "-".join(map(str, case[:3])))
def test_a_change_is_the_same_as_mathematics_and_in_mujoco_at_any_port(case):
    name, mechanism, place, *values = case
    change = ALL[mechanism](place, *values)
    wanted = response(change.edit(linear(name)))
    found = response(load(name).including(change).linear(*CHANNELS[name]))
    scale = np.abs(wanted).max(axis=0)
    assert np.abs((found - wanted) / scale).max() < 1e-8
    assert np.abs((response(linear(name)) - wanted) / scale).max() > 1e-5, (
        "the test shows something"
    )


@pytest.mark.parametrize(
    ("name", "mechanism", "place", "values", "force", "fine", "most"),
    LAWS,
    ids=lambda part: part if isinstance(part, str) else "",
)
def test_a_law_at_any_port_moves_a_structure_as_an_independent_integration_says(
    name, mechanism, place, values, force, fine, most
):
    law = ALL[mechanism](place, *values)
    samples, (inputs, outputs) = 900, CHANNELS[name]
    forces = np.zeros((samples, len(inputs)))
    for column in range(len(inputs)):
        forces[:, column] = force / 0.4 * push(samples, column) / (1 + column)
    given = dict(zip(inputs, forces.T, strict=True))
    columns = load(name).including(law).simulate(given, RATE, samples).columns
    found = np.column_stack([columns[output] for output in outputs])
    true = readings(linear(name), forces, law, fine)
    free = readings(linear(name), forces, None, 8 if name == "cantilever" else 2)
    assert error(found, true) < most
    assert error(free, true) > 3 * most, "the test shows something"


@pytest.mark.parametrize(
    ("mechanism", "place", "values"),
    [
        ("base_compliance", "ground.y", (2e4, 20.0, 5.0)),
        ("mass", "acc_floor2_b", (0.3,)),
        ("appendage", "floor2.y", (0.1, 4.0, 0.02)),
        ("appendage", "storey2_y", (0.1, 4.0, 0.02)),
    ],
)
def test_a_change_is_shaken_by_the_ground_as_the_structure_is(mechanism, place, values):
    change, time = ALL[mechanism](place, *values), np.arange(1200) / RATE
    shaking = 0.05 * np.sin(2 * np.pi * 3 * time) * np.minimum(time, 1)
    twin = load("portal_3d")
    model = change.edit(twin.linear(["acc_ground.y"], CHANNELS["portal_3d"][1]))
    true = free_run(model, shaking[:, None], RATE)
    columns = twin.including(change).simulate({}, RATE, 1200, {"y": shaking}).columns
    found = np.column_stack([columns[output] for output in model.outputs])
    assert error(found, true) < 1e-3


@pytest.mark.parametrize("name", CHANNELS)
def test_a_port_is_the_same_row_to_mathematics_and_to_the_edit_of_the_model(name):
    model, twin = linear(name), load(name)
    rest = Rest(mujoco.MjSpec.from_string(twin.mjcf))
    for kind in ("drift", "motion"):
        for place in model.places(kind):
            motion = rest.motion(place)
            assert motion.unit == model.port_of(place).unit
            stiff = ALL["stiffness"](place, 1.0)
            assert stiff.units(motion.unit)["change"] == (
                "N/m" if motion.unit == "m" else "N m/rad"
            )
    for place in model.places("drift"):
        assert rest.motion(place).mass == pytest.approx(model.carried(place))


def test_a_port_knows_what_leans_over_it():
    ports = linear("portal_3d").ports
    assert ports["storey2_x"].height == pytest.approx(0.312)
    assert ports["storey2_column1_x"].carries == ("floor2", "floor2_load1")
    chain = Twin.load("two_storey").linear(["force_floor2"], ["acc_floor2"]).ports
    assert chain["storey2"].height == pytest.approx(0.3189, abs=1e-3)
    beam = linear("cantilever").ports
    assert beam["hinge10"].height == pytest.approx(0.015)
    assert 0.25 < beam["hinge1"].height < 0.31


def test_what_sits_on_a_motor_is_offered_where_one_drives_a_joint():
    friction, delay = ALL["pendulum_friction"], ALL["motor_delay"]
    absorber = Twin.load("two_storey_absorber")
    model = absorber.linear(["force_floor2", "torque_pendulum"], ["angle_pendulum"])
    for chain in (model, absorber.second_order()):
        assert mechanisms.places(friction, chain, {}) == ["pendulum"]
        # and under one name only
        assert "pendulum" not in mechanisms.places(ALL["coulomb_friction"], chain, {})
        assert mechanisms.places(delay, chain, {}) == ["torque_pendulum"]
    # friction along a slide has one name
    assert mechanisms.places(friction, linear("drive"), {}) == []
    assert "slide" in mechanisms.places(ALL["coulomb_friction"], linear("drive"), {})
    assert mechanisms.places(delay, linear("drive"), {}) == ["force"]
    assert friction.units("m") == {"torque": "N", "regular_rate": "m/s"}
    assert mechanisms.places(delay, linear("portal_3d"), {}) == []
    rubbing = load("drive").including(friction("slide", 20.0))
    assert rubbing.compile().dof_frictionloss[0] == 20.0


def test_every_mechanism_is_offered_at_ports_of_its_kind_in_three_dimensions():
    model = linear("portal_3d")
    kinds = dict.fromkeys(model.outputs, "acc")
    offered = {name: mechanisms.places(cls, model, kinds) for name, cls in ALL.items()}
    assert "storey1_column2_y" in offered["cubic_stiffness"]
    assert "floor2.rz" in offered["appendage"]
    assert set(offered["mass"]) == {"floor1", "floor1_load1", "floor2", "floor2_load1"} & set(
        model.bodies
    )
    assert offered["base_compliance"] == ["ground.x", "ground.y"]
    assert {"floor1.y", "ground.y"} <= set(offered["unmeasured_force"])
    assert offered["sensor_hum"] == list(model.outputs)
    assert len(offered["sensor_crosstalk"]) == 6


def test_a_place_in_a_frame_that_is_not_there_is_an_error_that_lists_those_that_are():
    for place, there in (("column9", "storey1_x, storey1_y"), ("floor1", "floor1.x, floor1.y")):
        with pytest.raises(ModelError, match=there):
            load("portal_3d").including(ALL["stiffness"](place, 1.0))
    with pytest.raises(ModelError, match="floor1"):
        ALL["mass"]("roof", 1.0).edit(linear("portal_3d"))
    with pytest.raises(ModelError, match="nothing moves"):
        load("portal_3d").including(ALL["damping"]("floor1.z", 1.0))
    with pytest.raises(ModelError, match=r"ground.x, ground.y"):
        ALL["base_compliance"]("ground.z", 1e4, 1.0, 1.0).edit(linear("portal_3d"))
    with pytest.raises(ModelError, match="carries nothing"):
        ALL["p_delta"]("floor1.x", 1.0, 0.3).edit(linear("portal_3d"))


def test_joints_and_bodies_without_names_are_edited_as_well():
    twin = Twin(
        """<mujoco><compiler angle="radian"/><option gravity="0 0 0"/><worldbody><body>
        <joint type="slide" axis="1 0 0" stiffness="900" damping="1"/>
        <inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/><site name="top"/></body></worldbody>
        <actuator><motor name="hit" site="top" gear="1 0 0 0 0 0"/></actuator>
        <sensor><accelerometer name="a" site="top"/></sensor></mujoco>"""
    )
    model = twin.linear(["hit"], ["a.x"])
    for change in (ALL["stiffness"]("top", 100.0), ALL["mass"]("body 1", 0.5)):
        wanted = response(change.edit(model))
        changed = twin.including(change)
        np.testing.assert_allclose(response(changed.linear(["hit"], ["a.x"])), wanted, rtol=1e-9)
        again = Twin(changed.mjcf_of()).including(change)
        assert again.linear(["hit"], ["a.x"]).K[0, 0] != model.K[0, 0]


def test_a_mass_that_is_taken_away_must_leave_a_rigid_body():
    spec = mujoco.MjSpec.from_string(load("portal_3d").mjcf)
    with pytest.raises(ModelError, match="leave no rigid body"):
        add_point_mass(spec, spec.site("acc_floor2_b"), -2.0)


def test_springs_are_at_ease_where_gravity_leaves_a_sagging_beam():
    beam = Twin(
        """<mujoco><compiler angle="radian"/><option integrator="RK4"/><worldbody>
        <body name="arm"><joint name="pin" axis="0 1 0" stiffness="50" damping="0.1"/>
        <inertial pos="0.4 0 0" mass="1" diaginertia="0.1 0.1 0.1"/><site name="tip" pos="0.8 0 0"/>
        </body></worldbody><actuator><motor name="push" site="tip" gear="0 0 1 0 0 0"/></actuator>
        <sensor><jointpos name="angle" joint="pin"/></sensor></mujoco>"""
    )
    for mechanism in (ALL["cubic_stiffness"]("pin", 5000.0), ALL["bumper"]("tip.z", 500.0, 0.01)):
        still = beam.including(mechanism).simulate({}, RATE, 50).columns["angle"]
        assert np.ptp(still) < 1e-9


def test_a_fault_sits_in_one_axis_of_a_vector_sensor():
    faulty = load("rotated_sensors").including(ALL["sensor_gain"]("acc_a.y", 1.1))
    seen = faulty.recorded({"acc_a.x": np.ones(3), "acc_a.y": np.ones(3)}, 100.0)
    assert seen["acc_a.x"] == pytest.approx(np.ones(3))
    assert seen["acc_a.y"] == pytest.approx(1.1 * np.ones(3))
    with pytest.raises(ModelError, match=r"no channel 'acc_q\.y'"):
        load("rotated_sensors").including(ALL["sensor_gain"]("acc_q.y", 1.1))
