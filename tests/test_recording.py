"""Channels of any name, and what of them drives the structure."""

import doctest

import numpy as np
import pytest

import twin.channel
import twin.recording
from twin.channel import Channel
from twin.errors import RecordingError
from twin.model import Twin
from twin.recording import Recording
from twin.sensor_kinds import channel_kinds

X = np.array([0.0, 1.0, -1.0])


def test_the_examples_in_the_docstrings_hold():
    for module in (twin.channel, twin.recording):
        result = doctest.testmod(module)
        assert result.attempted
        assert not result.failed


@pytest.mark.parametrize(
    ("name", "kind", "unit"),
    [
        ("force_floor12", "force", "N"),
        ("acc_ground.y", "acc", "m/s^2"),
        ("disp_floor1", "disp", "m"),
        ("angle_pendulum", "angle", "rad"),
        ("torque_pendulum", "torque", "N m"),
    ],
)
def test_a_name_of_the_frame_says_what_it_measures(name, kind, unit):
    channel = Channel(name)
    assert (channel.kind, channel.unit) == (kind, unit)
    with pytest.raises(RecordingError, match=f"'{name}' is by its name no voltage"):
        Channel(name, "voltage")


def test_any_other_name_needs_a_kind_and_is_told_what_to_write():
    with pytest.raises(RecordingError, match=r"'A3': nothing says .* as in 'A3 \[m/s\^2\]'"):
        Channel("A3")
    assert Channel("A3", "acc").title == "A3 [m/s^2]"
    with pytest.raises(RecordingError, match="unknown kind 'sound'; there are force, torque, acc"):
        Channel("A3", "sound")
    with pytest.raises(RecordingError, match="a force is in N"):
        Channel("A3", "force", "kN")


@pytest.mark.parametrize("name", ["", " a", "a ", "a\nb", "a [N]", "time"])
def test_a_name_that_no_file_can_hold_is_refused(name):
    with pytest.raises(RecordingError, match="channel"):
        Channel(name, "acc")


def test_a_bare_name_is_the_x_axis_of_a_vector_sensor():
    recording = Recording.build(1.0, {"tip.x [m]": X, "tip.y [m]": 2 * X, "A.b [m]": 3 * X})
    assert np.array_equal(recording.column("tip"), X)
    assert np.array_equal(recording.column("tip.x"), X)
    assert (Channel("tip.y", "acc").element, Channel("tip.y", "acc").axis) == ("tip", "y")
    assert (recording.channel("A.b").element, recording.channel("A.b").axis) == ("A.b", "")
    with pytest.raises(RecordingError, match=r"'tip' appears twice"):
        Recording.build(1.0, {"tip [m]": X, "tip.x [m]": X})
    with pytest.raises(RecordingError, match=r"no channel 'tip.z'; it has tip.x, tip.y, A.b"):
        recording.column("tip.z")


def test_columns_with_a_unit_are_converted():
    recording = Recording.build(1.0, {"A3 [g]": X, "speed [rpm]": X})
    assert recording.column("A3") == pytest.approx(9.80665 * X)
    assert recording.channel("speed").unit == "rad/s"


@pytest.mark.parametrize(
    ("columns", "inputs"),
    [
        ({"tip_force [N]": X, "A [g]": X}, ("tip_force",)),
        ({"motor [N m]": X, "acc_ground [g]": X, "A [g]": X}, ("motor",)),
        (
            {"acc_ground.x [g]": X, "acc_ground.y [g]": X, "A [g]": X},
            ("acc_ground.x", "acc_ground.y"),
        ),
        ({"acc_ground.x [g]": 0 * X, "acc_ground.y [g]": X, "A [g]": X}, ("acc_ground.y",)),
        ({"F [N]": X, "acc_ground [g]": X, "F2 [N]": 0 * X}, ("F",)),
        ({"F [N]": 0 * X, "acc_ground [g]": X}, ()),
        ({"A [g]": X, "u [V]": X}, ()),
    ],
)
def test_forces_torques_and_a_shaken_ground_drive(columns, inputs):
    recording = Recording.build(1.0, columns)
    assert recording.inputs == inputs
    assert not set(recording.outputs) & set(inputs)


def test_columns_of_different_length_are_refused_by_name():
    with pytest.raises(RecordingError, match="'a' has 3 samples and 'b' has 2"):
        Recording.build(1.0, {"a [m]": X, "b [m]": X[:2]})


def test_a_selection_keeps_the_kinds():
    recording = Recording.build(1.0, {"a [m]": X, "b [V]": X}).select(["b"])
    assert [c.title for c in recording.channels] == ["b [V]"]


def test_a_model_says_the_kinds_of_its_sensors_and_actuators():
    kinds = channel_kinds(Twin.load("two_storey_absorber").compile())
    assert kinds["acc_floor1"] == kinds["acc_floor1.z"] == "acc"
    assert kinds["disp_floor2"] == "disp"
    assert kinds["angle_pendulum"] == "angle"
    assert kinds["force_floor1"] == "force"
    assert kinds["torque_pendulum"] == "torque"
