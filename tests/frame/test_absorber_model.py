"""The pendulum on the frame: eq. (56) and large swings."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from twin.errors import ModelError
from twin.frame import FrameDesign, Pendulum, Storey
from twin.model import Twin

HEAVY = (Storey(1e6, second_moment=1e-3),)
"""A floor that the pendulum cannot move."""


def test_mass_and_stiffness_have_the_pendulum_entries_of_equation_56():
    m, arm, inertia = 0.083, 0.0825, 8.32e-4
    model = Twin.of(FrameDesign(kind="lumped", pendulum=Pendulum(), gravity=9.81)).second_order()
    assert model.coordinates == ("floor1", "floor2", "pendulum")
    np.testing.assert_allclose(
        model.M[2], [0, m * arm, inertia + m * arm**2], rtol=1e-9, atol=1e-12
    )
    assert model.M[1, 1] == pytest.approx(1.55 + m, rel=1e-9)
    assert model.K[2, 2] == pytest.approx(m * 9.81 * arm, rel=1e-8)


def test_the_inertia_can_be_meant_about_the_pivot():
    m, arm = 0.083, 0.0825
    pendulum = Pendulum(inertia_about="pivot")
    assert pendulum.pivot_inertia == pytest.approx(8.32e-4)
    assert pendulum.central_inertia == pytest.approx(8.32e-4 - m * arm**2)
    with pytest.raises(ModelError, match="less than m l"):
        Pendulum(inertia=1e-5, inertia_about="pivot")


def test_a_small_swing_on_a_heavy_floor_has_the_frequency_of_a_physical_pendulum():
    pendulum = Pendulum()
    twin = Twin.of(FrameDesign(HEAVY, "lumped", pendulum=pendulum))
    torque = np.zeros(20000)
    torque[:20] = 1e-4
    angle = twin.simulate({"torque_pendulum": torque}, 1000, 20000).columns["angle_pendulum"]
    crossing = np.flatnonzero(np.diff(np.signbit(angle[100:])))
    exact = crossing + angle[100 + crossing] / (angle[100 + crossing] - angle[101 + crossing])
    period = 2 * np.diff(exact).mean() / 1000
    restoring = pendulum.mass * 9.81 * pendulum.centre_distance
    expected = 2 * np.pi * np.sqrt(pendulum.pivot_inertia / restoring)
    assert period == pytest.approx(expected, rel=1e-5)


def test_a_large_swing_follows_the_equation_of_a_pendulum():
    pendulum = Pendulum(damping=1e-4)
    twin = Twin.of(FrameDesign(HEAVY, "lumped", pendulum=pendulum))
    rate, samples = 500, 2500
    t = np.arange(samples) / rate
    torque = 0.04 * np.sin(2 * np.pi * 0.8 * t)
    angle = twin.simulate({"torque_pendulum": torque}, rate, samples).columns["angle_pendulum"]
    J, c = pendulum.pivot_inertia, pendulum.damping
    weight = pendulum.mass * 9.81 * pendulum.centre_distance

    def swing(time, state):
        drive = np.interp(time, t, torque)
        return [state[1], (drive - c * state[1] - weight * np.sin(state[0])) / J]

    reference = solve_ivp(
        swing, (0, t[-1]), [0, 0], "DOP853", t, rtol=1e-12, atol=1e-14, max_step=1 / rate
    )  # it nearly stands on its head: at 1e-10 the reference itself is off
    assert np.abs(angle).max() > 1.5
    np.testing.assert_allclose(angle, reference.y[0], atol=1e-6 * np.abs(angle).max())


def test_a_positive_angle_swings_the_tip_to_positive_x_and_pushes_the_floor_back():
    twin = Twin.of(FrameDesign(pendulum=Pendulum()))
    torque = np.zeros(100)
    torque[1:4] = 0.01
    columns = twin.simulate({"torque_pendulum": torque}, 1000, 100).columns
    # With the tip's mass at a distance l below the pivot, the floor's first motion is opposite.
    assert columns["angle_pendulum"][20] > 0
    assert columns["disp_floor2"][20] < 0
    assert columns["acc_floor2"][2] < 0
