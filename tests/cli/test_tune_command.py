import json

import pytest

from twin.cli import main
from twin.formats import write_recording
from twin.laboratory import Experiment, Hammer, run
from twin.model import Twin


def twin(*arguments):
    with pytest.raises(SystemExit) as stop:
        main([str(argument) for argument in arguments])
    return stop.value.code


def test_tuning_picks_a_controller_resumes_and_says_what_limits_lack(tmp_path, capsys):
    hit = write_recording(run(Experiment(Hammer()), Twin.load("two_storey")), tmp_path / "hit.csv")
    options = ("tune", hit, "--excite", "floor1", "--candidates", 2, "--out", tmp_path / "t")
    assert twin(*options) == 0
    first = json.loads((tmp_path / "t" / "tune.json").read_text())
    assert first["picked"]["worst_swing_rad"] <= 0.8
    assert first["picked"]["worst_torque_nm"] <= 0.5
    assert first["picked"]["reduction"] >= 0.9
    assert abs(first["loss"]) <= 0.03
    assert first["picked"]["name"] in {row["name"] for row in first["front"]}
    settings = json.loads((tmp_path / "t" / "settings.json").read_text())["settings"]
    assert settings == first["settings"]
    trials = (tmp_path / "t" / "trials.jsonl").read_bytes()
    capsys.readouterr()

    assert twin(*options, "--max-swing", 0.01) == 2
    error = capsys.readouterr().err
    assert "meets the limits: the nearest swings" in error
    assert "more than 0.01" in error
    assert (tmp_path / "t" / "trials.jsonl").read_bytes() == trials
