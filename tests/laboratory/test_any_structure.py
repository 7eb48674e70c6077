"""Virtual tests on structures that are no chain of storeys."""

import json

import numpy as np
import pytest

from twin import hammer_test, shaker_test
from twin.cli import main
from twin.errors import ExperimentError
from twin.formats import read_recording
from twin.instruments import Instrument
from twin.laboratory import (
    Analyser,
    Experiment,
    Multisine,
    RandomShaking,
    run,
)
from twin.model import Twin

IDEAL = {kind: Instrument(bits=None) for kind in ("acc", "force", "disp")}
SHORT = Analyser(64.0, 8.0)


@pytest.fixture(scope="module")
def portal():
    return Twin.load("portal_3d")


def command(monkeypatch, capsys, *arguments):
    """Run the command; return its exit status and what it said."""
    monkeypatch.setattr("sys.argv", ["twin", *arguments])
    with pytest.raises(SystemExit) as done:
        main()
    said = capsys.readouterr()
    return done.value.code or 0, said.out + said.err


def test_two_shakers_have_signals_of_their_own(portal):
    shaking = RandomShaking(1.0, (0.5, 20.0))
    places = ("force_floor1_x", "force_floor2_y")
    both = run(Experiment(shaking, places, SHORT, instruments=IDEAL), portal)
    one = run(Experiment(shaking, places[0], SHORT, instruments=IDEAL), portal)
    assert both.inputs == places
    forces = both.matrix(places)
    assert abs(np.corrcoef(forces.T)[0, 1]) < 0.3
    np.testing.assert_array_equal(one.column(places[0]), forces[:, 0])
    alone = run(Experiment(shaking, places[0], SHORT, ("acc_floor2_a.x",), IDEAL), portal)
    assert np.std(both.column("acc_floor2_a.x") - alone.column("acc_floor2_a.x")) > 0.01


def test_accelerations_that_vary_are_recorded_axis_by_axis(portal):
    test = Experiment(RandomShaking(1.0, (0.5, 20.0)), "floor1_x", SHORT)
    axes = [f"acc_floor{i}_{corner}.{axis}" for i in (1, 2) for corner in "ab" for axis in "xy"]
    assert run(test, portal).names == ("force_floor1_x", *axes)


def test_a_slow_motion_of_the_ground_carries_the_floors_along(portal):
    slow = Multisine(0.5, (0.15, 0.3), 2)
    test = Experiment(slow, (), Analyser(16.0, 32.0), None, IDEAL, 20.0, ("y",))
    recording = run(test, portal)
    assert recording.inputs == ("acc_ground.y",)
    ground = recording.column("acc_ground.y")
    # the highest line is at (0.3 / 3.8)^2 = 0.6 % of the first mode's squared frequency
    assert np.std(recording.column("acc_floor2_b.y") - ground) < 0.02 * np.std(ground)
    assert np.std(recording.column("acc_floor2_b.x")) < 0.02 * np.std(ground)


def test_what_has_no_accelerometer_is_recorded_by_its_other_sensors():
    test = Experiment(RandomShaking(20.0, (0.5, 5.0)), "force", SHORT, instruments=IDEAL)
    recording = run(test, Twin.load("drive"))
    assert [channel.title for channel in recording.channels] == ["force [N]", "position [m]"]


def test_one_call_is_a_virtual_test(portal):
    hit = hammer_test("cantilever", "force_tip", peak_n=1.0, rate_hz=64, duration_s=2.0)
    assert hit.names == ("force_tip", "acc_low", "acc_mid", "acc_tip")
    short = {"rate_hz": 64.0, "duration_s": 2.0, "band_hz": (0.5, 20.0)}
    pushed = shaker_test(portal, ("force_floor1_x", "force_floor2_y"), noise=0.0, **short)
    again = shaker_test(portal, ("force_floor1_x", "force_floor2_y"), noise=0.0, **short)
    np.testing.assert_array_equal(pushed.data, again.data)
    shaken = shaker_test(portal, ground=("y",), sensors=("acc_floor2_a.y",), **short)
    assert shaken.names == ("acc_ground.y", "acc_floor2_a.y")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"at": "force_top"}, "no 'force_top' to act on; there is floor1_x, floor1_y"),
        ({"at": ("floor1_x", "floor1_x")}, "two shakers act on 'floor1_x'"),
        ({"at": ()}, "needs a place"),
        ({"ground": ("q",)}, "no axis 'q' of the ground; there are x, y, z"),
    ],
)
def test_what_cannot_be_shaken_is_said(portal, options, message):
    with pytest.raises(ExperimentError, match=message):
        run(Experiment(RandomShaking(1.0, (0.5, 20.0)), analyser=SHORT, **options), portal)


def test_the_command_hits_any_actuator_and_records_chosen_axes(monkeypatch, capsys, tmp_path):
    words = ["test", "hammer", "cantilever", "--at", "force_tip", "--peak", "1", "--rate", "128"]
    words += ["--duration", "2", "--sensor", "acc_tip.x", "--out", str(tmp_path)]
    status, _ = command(monkeypatch, capsys, *words, "--json", str(tmp_path / "said.json"))
    assert status == 0
    recording = read_recording(tmp_path / "hammer_force_tip.csv")
    assert recording.inputs == ("force_tip",)
    assert len(recording.outputs) == 1
    assert json.loads((tmp_path / "said.json").read_text())["inputs"] == ["force_tip"]


def test_the_command_shakes_at_several_points_or_the_ground(monkeypatch, capsys, tmp_path):
    common = ["--rate", "64", "--duration", "2", "--out", str(tmp_path)]
    several = ["--at", "force_a", "--at", "force_b"]
    status, _ = command(monkeypatch, capsys, "test", "shaker", "rotated_sensors", *several, *common)
    assert status == 0
    recording = read_recording(tmp_path / "random_force_a+force_b.csv")
    assert recording.inputs == ("force_a", "force_b")
    along = ["--ground", "y", "--kind", "sweep"]
    status, _ = command(monkeypatch, capsys, "test", "shaker", "rotated_sensors", *along, *common)
    assert status == 0
    assert read_recording(tmp_path / "sweep_ground_y.csv").inputs == ("acc_ground.y",)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("portal_3d",), "--at which actuator? There is force_floor1_x"),
        (("portal_3d", "--at", "floor1_x", "--ground", "x"), "not both"),
    ],
)
def test_the_command_says_what_there_is(monkeypatch, capsys, tmp_path, words, message):
    status, said = command(
        monkeypatch, capsys, "test", "shaker", *words, "--out", str(tmp_path / "new")
    )
    assert status == 2
    assert message in said.replace("\n", " ")
    assert not (tmp_path / "new").exists()
