import json

import numpy as np
import pytest

from twin.cli import main
from twin.formats import read_recording


def twin(*arguments):
    with pytest.raises(SystemExit) as stop:
        main([str(argument) for argument in arguments])
    return stop.value.code


def test_the_absorber_calms_the_worst_case_as_well_as_one_that_knows_the_truth(tmp_path):
    options = ("--excite", "floor1", "--out", tmp_path, "--json", tmp_path / "c.json")
    assert twin("control", *options) == 0
    result = json.loads((tmp_path / "c.json").read_text())
    true = result["with_true_model"]
    for floor in ("floor1", "floor2"):
        assert result["reduction"]["steady"][floor] >= 0.90
        loss = true["reduction"]["steady"][floor] - result["reduction"]["steady"][floor]
        assert abs(loss) <= 0.03
    assert result["peak_swing_rad"] <= 0.8
    assert result["peak_torque_nm"] <= 0.5
    assert result["stability_margin"] > 0.3
    assert result["notes"] == []
    assert result["pendulum"]["inertia_about"] == "centre"
    assert result["windows_s"]["off"] == [0.0, 32.0]
    assert result["identified"]["coordinates"] == ["floor1", "floor2"]
    assert {"controller.c", "controller.mat"} <= {p.name for p in tmp_path.iterdir()}
    run = read_recording(tmp_path / "run.csv")
    assert run.duration_s == 64.0
    assert run.names[0] == "force_floor1"
    assert np.abs(run.column("disp_floor1")[:1024]).max() > 5e-3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--model", "two_storey"], "lacks actuator torque_pendulum and sensor angle_pendulum"),
        (["--rate", "2000"], "cannot be stepped at 2000 Hz"),
        (["--rate", "9"], "too slow: the mode at 5.7"),
        (["--earthquake", "quake.csv"], "an earthquake needs the shake table"),
        (["--settings", "none.json"], "none.json: no settings of a controller"),
        (["--torque-limit", "-1"], "must be positive, not -1 N m"),
    ],
)
def test_bad_input_ends_in_one_line(capsys, options, message):
    assert twin("control", "--excite", "floor1", *options) == 2
    error = capsys.readouterr().err
    assert message in error
    assert len(error.strip().splitlines()) == 1
