"""Matrices and modes of models whose answer is known in closed form."""

import mujoco
import numpy as np
import pytest

from twin.errors import ModelError
from twin.linearise import linearise
from twin.model import Twin
from twin.model.rest import equilibrium


def model(body, rest="", gravity=9.81):
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian"/><option gravity="0 0 {-gravity}"/>'
        f"<worldbody>{body}</worldbody>{rest}</mujoco>"
    )


def inertial(mass, z=0.0, turning=1e-3):
    return f'<inertial pos="0 0 {z}" mass="{mass}" diaginertia="{turning} {turning} {turning}"/>'


def test_a_hanging_pendulum_has_its_closed_form_frequency_and_damping():
    body = f'<body><joint axis="0 1 0" damping="0.01"/>{inertial(2, -0.4, 0.05)}</body>'
    modes = linearise(model(body)).modes()
    inertia, weight = 0.05 + 2 * 0.4**2, 2 * 9.81 * 0.4
    omega = np.sqrt(weight / inertia)
    np.testing.assert_allclose(2 * np.pi * modes.natural_freq, omega, rtol=1e-9)
    np.testing.assert_allclose(modes.damping_ratio, 0.01 / (2 * inertia * omega), rtol=1e-9)


def test_a_sagging_mass_is_linearised_where_it_rests():
    spring = '<body><joint type="slide" axis="0 0 1" stiffness="100 0 {}"/>{}</body>'
    system = model(spring.format(5e4, inertial(1)))
    (sag,) = np.roots([5e4, 0, 100, 9.81])[np.isreal(np.roots([5e4, 0, 100, 9.81]))].real
    assert equilibrium(system)[0] == pytest.approx(sag, rel=1e-9)
    tangent = 100 + 3 * 5e4 * sag**2
    linear = linearise(system)
    assert linear.generalised.K[0, 0] == pytest.approx(tangent, rel=1e-8)


def test_a_coupling_leaves_one_freedom_with_the_masses_of_both_bodies():
    def mass(name, value, stiffness):
        joint = f'<joint name="{name}" type="slide" axis="1 0 0" stiffness="{stiffness}"/>'
        return f"<body>{joint}{inertial(value)}</body>"

    couple = '<equality><joint joint1="b" joint2="a" polycoef="0 2 0 0 0"/></equality>'
    linear = linearise(model(mass("a", 1, 50) + mass("b", 3, 20), couple))
    # x_b = 2 x_a: effective mass 1 + 4*3, stiffness 50 + 4*20.
    modes = linear.undamped_modes()
    assert 2 * np.pi * modes.natural_freq == pytest.approx(np.sqrt(130 / 13), rel=1e-9)


def test_a_bead_on_a_ring_held_by_a_connect_constraint_has_the_frequency_of_a_pendulum():
    joints = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>'
    arm = f'<body pos="0 0 1"><joint axis="0 1 0"/>{inertial(1e-6, -0.5, 1e-9)}'
    arm += '<body name="tip" pos="0 0 -0.5"/></body>'
    bead = f'<body name="bead" pos="0 0 0.5">{joints}{inertial(1)}</body>'
    tie = '<equality><connect body1="bead" body2="tip" anchor="0 0 0"/></equality>'
    modes = linearise(model(bead + arm, tie)).undamped_modes()
    assert 2 * np.pi * modes.natural_freq == pytest.approx(np.sqrt(9.81 / 0.5), rel=1e-5)


def test_condensation_keeps_static_stiffness_and_raises_frequencies():
    from twin.frame import FrameDesign

    linear = Twin.of(FrameDesign(kind="hinge_chain", segments=6)).linearisation()
    assert linear.condensed
    condensed = linear.second_order()
    exact = linear.undamped_modes()
    compliance = linear.shape @ np.linalg.solve(linear.generalised.K, linear.shape.T)
    np.testing.assert_allclose(condensed.K, np.linalg.inv(compliance), rtol=1e-8)
    ratio = condensed.undamped_modes().natural_freq / exact.natural_freq[:2]
    assert np.all((ratio > 1) & (ratio < 1.01))


def test_places_and_matrices_agree_with_the_modes():
    twin = Twin.load("two_storey_absorber").released()
    linear = twin.linearisation()
    assert linear.places == ("floor1", "floor2", "ground", "pendulum")
    assert not linear.condensed
    again = linear.second_order().modes()
    np.testing.assert_allclose(again.natural_freq, linear.modes().natural_freq, rtol=1e-9)
    np.testing.assert_allclose(again.amplitude, linear.modes().amplitude, rtol=1e-6)


def test_what_cannot_move_or_rest_is_refused():
    with pytest.raises(ModelError, match="no joint"):
        linearise(model(f"<body>{inertial(1)}</body>"))
    held = f'<body><joint name="a" type="slide" axis="1 0 0"/>{inertial(1)}</body>'
    with pytest.raises(ModelError, match="nothing that moves"):
        linearise(model(held, '<equality><joint joint1="a"/></equality>'))
    falls = f'<body><joint type="slide" axis="0 0 1"/>{inertial(1)}</body>'
    with pytest.raises(ModelError, match="no static equilibrium"):
        linearise(model(falls))


def test_linearising_leaves_the_model_as_it_was():
    compiled = Twin.load("two_storey").compile()
    before = (compiled.opt.jacobian, compiled.qpos0.copy())
    linearise(compiled)
    assert compiled.opt.jacobian == before[0]
    np.testing.assert_array_equal(compiled.qpos0, before[1])
