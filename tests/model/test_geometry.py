"""What large motion adds, beside exact equations and MuJoCo's own simulation."""

import numpy as np
import pytest
from test_linear import inertial, mjcf

from twin.model import Twin
from twin.model.geometry import Geometry, geometry_of
from twin.model.self_check import linear_prediction, simulated

LENGTH, MASS, G = 0.5, 2.0, 9.81
PENDULUM = mjcf(
    f'<body><joint name="hinge" axis="0 1 0" damping="0.01"/>{inertial(MASS, -LENGTH)}'
    f'<site name="bob" pos="0 0 {-LENGTH}"/></body>',
    '<actuator><motor name="motor" joint="hinge"/></actuator>'
    '<sensor><accelerometer name="acc" site="bob"/><jointpos name="angle" joint="hinge"/></sensor>',
)


def pendulum(mjcf_text=PENDULUM):
    twin = Twin(mjcf_text)
    model = twin.linear(["motor"], ["angle", "acc.x"])
    return twin, model


def test_a_pendulum_gets_the_gravity_that_its_tangent_lacks():
    twin, model = pendulum()
    angle = np.linspace(-0.4, 0.4, 9)
    scale = float(model.shapes[0, 0])  # angle for a unit of the coordinate
    q = (angle / scale)[:, None]
    found = Geometry(twin, model).along(q, 0 * q, np.zeros((9, 1)))
    exact = -MASS * G * LENGTH * (np.sin(angle) - angle) * scale
    assert found.forces[:, 0] == pytest.approx(exact, abs=1e-6 * np.max(np.abs(exact)))
    assert found.readings[:, 0] == pytest.approx(0 * angle, abs=1e-9)
    # the accelerometer turns with the rod and reads gravity's share along its axis
    assert found.readings[:, 1] == pytest.approx(-G * (np.sin(angle) - angle), abs=1e-6)


def test_a_cubic_spring_is_left_to_the_law_that_stands_for_it():
    hardening = PENDULUM.replace('damping="0.01"', 'damping="0.01" stiffness="3 0 50"')
    plain = PENDULUM.replace('damping="0.01"', 'damping="0.01" stiffness="3"')
    q = np.linspace(-0.5, 0.5, 7)[:, None]
    forces = [
        Geometry(*pendulum(text)).along(q, q, np.zeros((7, 1))).forces
        for text in (hardening, plain)
    ]
    assert forces[0] == pytest.approx(forces[1], abs=1e-6)


def test_a_force_that_the_model_does_not_hold_accelerates_what_has_turned_as_an_input_does():
    double = mjcf(
        f'<body><joint name="upper" axis="0 1 0"/>{inertial(MASS, -LENGTH)}'
        f'<body pos="0 0 {-2 * LENGTH}"><joint name="lower" axis="0 1 0"/>'
        f'{inertial(MASS, -LENGTH)}<site name="bob" pos="0 0 {-LENGTH}"/></body></body>',
        '<actuator><motor name="motor" joint="upper"/></actuator>'
        '<sensor><accelerometer name="acc" site="bob"/></sensor>',
    )
    twin = Twin(double)
    model = twin.linear(["motor"], ["acc.x", "acc.z"])
    geometry, rng = Geometry(twin, model), np.random.default_rng(6)
    q, v, u = 0.3 * rng.standard_normal((5, 2)), rng.standard_normal((5, 2)), np.ones((5, 1))
    driven = geometry.along(q, v, u)
    pushed = geometry.along(q, v, 0 * u, u @ model.B.T)
    left = geometry.along(q, v, 0 * u)
    np.testing.assert_allclose(pushed.forces, driven.forces, atol=1e-6)
    np.testing.assert_allclose(pushed.readings, driven.readings, atol=1e-6)
    assert np.max(np.abs(left.readings - driven.readings)) > 1e-2


@pytest.mark.parametrize(
    ("name", "inputs", "outputs", "level"),
    [
        ("two_storey", ("force_floor1",), ("acc_floor1", "acc_floor2"), 0.5),
        ("cantilever", ("force_tip",), ("acc_mid", "acc_tip"), 1.0),
        ("portal_3d", ("force_floor1_x",), ("acc_floor1_a.x", "acc_floor1_a.y"), 3.0),
        ("portal_3d", ("acc_ground.y",), ("acc_floor1_b.x", "acc_floor1_b.y"), 0.5),
        ("two_storey", ("acc_ground",), ("acc_floor1", "acc_floor2"), 2.0),
    ],
)
def test_a_free_run_with_pseudo_forces_is_mujocos_ten_times_as_closely(
    name, inputs, outputs, level
):
    twin, rate = Twin.load(name), 128.0
    model = twin.linear(inputs, outputs)
    sos_noise = np.random.default_rng(4).standard_normal(1200)
    u = level * np.convolve(sos_noise, np.hanning(17) / 8, "same")[:, None]
    motion = simulated(twin, model, dict(zip(inputs, u.T, strict=True)), rate)
    true = np.column_stack([motion.column(o) for o in outputs])
    linear = linear_prediction(model, u, rate)
    more = Geometry(twin, model).simulated(u, rate)
    missed = np.sqrt(np.mean((linear - true) ** 2, axis=0))
    left = np.sqrt(np.mean((linear + more - true) ** 2, axis=0))
    assert np.max(missed / np.std(true, axis=0)) > 0.01
    assert np.max(left) < 0.1 * np.max(missed)


def test_a_joint_whose_place_is_no_number_has_no_geometry_here():
    ball = mjcf(
        f'<body><joint name="ball" type="ball" stiffness="20" damping="0.1"/>{inertial(1, -0.3)}'
        '<site name="end" pos="0 0 -0.3"/></body>',
        '<actuator><motor name="push" site="end" gear="1 0 0 0 0 0"/></actuator>'
        '<sensor><accelerometer name="acc" site="end"/></sensor>',
    )
    twin = Twin(ball)
    assert geometry_of(twin, twin.linear(["push"], ["acc.x"])) is None
