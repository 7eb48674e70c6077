import json

import pytest

from twin.cli import main


def twin(*arguments):
    with pytest.raises(SystemExit) as stop:
        main([str(argument) for argument in arguments])
    return stop.value.code


def test_a_model_is_listed_with_ports_modes_and_mechanisms(tmp_path, capsys):
    assert twin("inspect", "portal_3d", "--json", tmp_path / "p.json") == 0
    shown = capsys.readouterr().out
    found = json.loads((tmp_path / "p.json").read_text())
    names = {port["name"] for port in found["ports"]}
    assert {"storey1_column3_x", "floor2.rz", "floor1.y"} <= names
    assert "storey1_column3_x" in shown
    assert found["inputs"]["force_floor1_x"] == "force"
    assert found["inputs"]["acc_ground.y"] == "acc"
    assert found["outputs"]["acc_floor2_a.y"] == "acc"
    assert len(found["modes"]) == 6
    frequencies = [mode["frequency_hz"] for mode in found["modes"]]
    assert frequencies == sorted(frequencies)
    for mode in found["modes"]:
        assert set(mode["movers"]) <= names
        assert max(mode["movers"].values()) == 1
    assert "storey1_column3_x" in found["mechanisms"]["coulomb_friction"]
    assert found["bodies"]["floor1"] > 0


def test_a_drive_has_a_rigid_body_mode(capsys):
    assert twin("inspect", "drive", "--json", "-") == 0
    found = json.loads(capsys.readouterr().out)
    assert found["modes"][0]["frequency_hz"] == 0
    assert found["modes"][0]["damping_ratio"] is None
    assert found["inputs"]["force"] == "force"
    assert found["outputs"]["position"] == "disp"


def test_what_is_not_linear_and_what_drives_nothing_is_said(tmp_path, capsys):
    path = tmp_path / "mine.xml"
    path.write_text(
        '<mujoco><worldbody><body name="m"><joint name="a" type="slide" axis="1 0 0" '
        'stiffness="90 0 7"/><geom size="0.1"/></body><site name="s"/></worldbody>'
        '<actuator><motor name="idle" site="s" gear="1 0 0 0 0 0"/></actuator></mujoco>'
    )
    assert twin("inspect", path) == 0
    shown = capsys.readouterr().out
    assert "not linear: joint a: a spring with 7 d^3 (cubic_stiffness)" in shown
    assert "no input: idle: nothing it acts on moves" in shown


def test_what_is_neither_model_nor_recording_is_one_line(tmp_path, capsys):
    assert twin("inspect", tmp_path / "gone.csv") == 2
    assert "no such file, and no model that comes with the package" in capsys.readouterr().err
    (tmp_path / "bad.xml").write_text("<mujoco><worldbody/></mujoco>")
    assert twin("inspect", tmp_path / "bad.xml") == 2
    assert "the model has no joint: nothing moves" in capsys.readouterr().err
