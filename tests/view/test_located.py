"""Where a place is in the model, whatever its name, and how brightly it is lit."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from diagnosis_example import CUBIC, MECHANISMS, diagnosis

from twin.diagnosis.result import Finding
from twin.model import Twin
from twin.view.chart import Chart
from twin.view.located import region, shares
from twin.view.magnified import factor, magnified


def box(model_name, place):
    twin = Twin.load(model_name)
    model = twin.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    found = region(model, twin.linear((), ()).ports, place)
    return None if found is None else (model, data, found.box(model, data))


def test_a_hinge_is_between_the_links_that_it_holds_together():
    _, data, (centre, half) = box("cantilever", "hinge5")
    link, below = data.body("link5").xpos, data.body("link4").xpos
    for spot in (link, below):
        assert np.all(np.abs(spot - centre) <= half + 1e-6)
    assert np.any(np.abs(data.body("link8").xpos - centre) > half)


@pytest.mark.parametrize("place", ["storey1_x", "floor2.rz", "acc_floor2_a.x", "force_floor2_y"])
def test_joints_bodies_sensors_and_actuators_of_a_portal_have_a_place(place):
    assert box("portal_3d", place) is not None


def test_what_the_model_has_not_has_no_place():
    assert box("cantilever", "storey1") is None


def test_a_small_finding_is_lit_less_than_the_large_one():
    found = diagnosis(CUBIC)
    large = found.force[0]
    small = replace(large, place="storey2", latent=0.003 * large.latent)
    second = Finding(MECHANISMS["coulomb_friction"]("storey2", 0.1), {}, 0.9)
    parts = shares(replace(found, findings=(*found.findings, second), force=(large, small)))
    assert parts["storey1"] == pytest.approx(1 / 1.003)
    assert parts["storey2"] == pytest.approx(0.003 / 1.003)


def test_an_instrument_is_lit_by_its_probability():
    gain = Finding(MECHANISMS["sensor_gain"]("acc_floor1", 0.1), {}, 0.7)
    found = replace(diagnosis(CUBIC), findings=(gain,), force=())
    assert shares(found) == {"acc_floor1": pytest.approx(0.7)}


def test_a_magnified_motion_is_so_many_times_as_far_from_rest():
    twin = Twin.load("two_storey_lumped")
    push = 0.01 * np.sin(12 * np.arange(64) / 64)
    motion = twin.simulate({"force_floor1": push}, 64.0, 64)
    by = factor(motion)
    assert by >= 10
    larger = magnified(motion, by)
    rest = motion.qpos[0]
    np.testing.assert_allclose(larger.qpos - rest, by * (motion.qpos - rest), atol=1e-12)
    assert factor(larger) <= 2


def test_a_chart_puts_its_ends_at_its_corners():
    chart = Chart(None, "x", (0.0, 10.0), (0.1, 1000.0), "", "", y_log=True)
    corners = chart.place(np.array([0.0, 10.0]), np.array([0.1, 1000.0]))
    np.testing.assert_allclose(corners, [[0.0, 90.0], [160.0, 0.0]], atol=1e-9)
    middle = chart.place(np.array([5.0]), np.array([10.0]))
    np.testing.assert_allclose(middle, [[80.0, 45.0]])
