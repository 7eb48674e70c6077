"""The prediction beside MuJoCo's own motion, and what is named where they differ."""

import numpy as np
import pytest
from test_linear import PLANE, PLANE_REST, inertial, mjcf

from twin.errors import ModelError
from twin.model import Twin
from twin.model.self_check import self_check

ARM = mjcf(
    f'<body name="upper"><joint name="shoulder" axis="0 1 0" damping="0.002"/>{inertial(1, -0.3)}'
    f'<body pos="0 0 -0.6"><joint name="elbow" axis="0 1 0" damping="0.002"/>{inertial(1, -0.3)}'
    '<site name="hand" pos="0 0 -0.6"/></body></body>',
    '<actuator><motor name="motor" joint="shoulder"/></actuator>'
    '<sensor><accelerometer name="acc" site="hand"/></sensor>',
)


def noise(samples, scale=1.0, seed=5):
    return scale * np.random.default_rng(seed).standard_normal(samples)


@pytest.mark.parametrize("ground", [False, True])
def test_a_linear_model_passes_far_below_its_noise(ground):
    twin = Twin(mjcf(PLANE, PLANE_REST))
    inputs = {"acc_ground.x": noise(600, 1e-3), "acc_ground.y": noise(600, 1e-3, 6)}
    inputs = inputs if ground else {"hit": noise(600, 1e-3)}
    outputs = ["A1.x", "A1.y", "laser.x", "laser.y", "doppler.x", "spin.z"]
    check = self_check(twin, inputs, outputs, 200)
    assert check.passed
    assert max(check.differences.values()) < 1e-4
    assert check.cause == ""
    check.require()


def test_an_arm_that_swings_freely_is_refused_by_the_joint_that_turns():
    gentle = self_check(Twin(ARM), {"motor": noise(400, 0.01)}, ["acc.x"], 100)
    assert gentle.passed
    wild = self_check(Twin(ARM, "arm.xml"), {"motor": noise(2000, 40.0)}, ["acc.x"], 100)
    with pytest.raises(ModelError, match=r"arm\.xml: .* joint (elbow|shoulder) turns by up to"):
        wild.require()
    with pytest.raises(ModelError, match=r"at \S+ of the inputs they miss"):
        wild.require()


def test_a_difference_that_is_small_but_seen_gets_its_cause_without_being_refused():
    check = self_check(Twin(mjcf(PLANE, PLANE_REST)), {"hit": noise(600, 3.0)}, ["A1.x"], 200)
    assert check.passed
    assert 0.1 < check.of_noise["A1.x"] < 1
    assert "joint twist turns by up to" in str(check)


def test_an_arm_that_stands_on_its_head_is_refused_by_its_joint():
    upright = ARM.replace('gravity="0 0 -9.81"', 'gravity="0 0 9.81"')
    with pytest.raises(ModelError, match=r"rest is not stable, .* joint (elbow|shoulder) gives"):
        self_check(Twin(upright), {"motor": noise(50)}, ["acc.x"], 100)


def test_an_element_that_is_not_linear_is_named_where_it_matters_and_only_there():
    text = mjcf(PLANE, PLANE_REST).replace('stiffness="900"', 'stiffness="900 0 5e5"')
    strong = self_check(Twin(text, "mine"), {"hit": noise(600, 5.0)}, ["A1.x"], 200)
    with pytest.raises(ModelError, match=r"mine: .* joint sx: a spring with 5e\+05 d\^3"):
        strong.require()
    weak = self_check(Twin(text), {"hit": noise(600, 0.01)}, ["A1.x"], 200)
    assert weak.passed
    assert 0 < weak.effects[0].share < 1e-3


def test_a_prediction_of_another_model_is_named_by_its_mode():
    twin = Twin(mjcf(PLANE, PLANE_REST))
    other = Twin(mjcf(PLANE, PLANE_REST).replace('stiffness="1400"', 'stiffness="1500"'))
    force = {"hit": noise(2000, 1e-3)}
    wrong = other.simulate(force, 200, 2000)
    predicted = {"A1.y": wrong.column("A1.y")}
    check = self_check(twin, force, ["A1.y"], 200, predicted=predicted)
    assert not check.passed
    assert "near mode 3" in check.cause or "near mode 2" in check.cause


def test_noise_says_what_difference_is_allowed():
    text = mjcf(PLANE, PLANE_REST).replace('stiffness="900"', 'stiffness="900 0 5e5"')
    force = {"hit": noise(600, 0.5)}
    loud = self_check(Twin(text), force, ["A1.x"], 200, noise={"A1.x": 10.0})
    quiet = self_check(Twin(text), force, ["A1.x"], 200, noise={"A1.x": 1e-9})
    assert loud.passed
    assert not quiet.passed
    assert loud.differences == quiet.differences
