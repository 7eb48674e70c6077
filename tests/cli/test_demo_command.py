import json

import numpy as np
import pytest

from twin.cli import main
from twin.formats import read_recording


def test_the_demo_writes_everything_and_finds_the_true_modes(tmp_path, capsys):
    with pytest.raises(SystemExit) as stop:
        main(["demo", "--out", str(tmp_path / "demo"), "--json", str(tmp_path / "demo.json")])
    assert stop.value.code == 0
    names = {p.name for p in (tmp_path / "demo").iterdir()}
    assert {"hammer.csv", "identification.rrd", "mode_shapes.png"} <= names
    assert read_recording(tmp_path / "demo" / "hammer.csv").samples == 1024
    found = json.loads((tmp_path / "demo.json").read_text())
    true = [1.72357, 5.77414]
    np.testing.assert_allclose([m["frequency_hz"] for m in found["modes"]], true, rtol=1e-4)
    assert "look at it" in capsys.readouterr().out


def test_view_refuses_what_is_no_rerun_recording(tmp_path, capsys):
    file = tmp_path / "x.rrd"
    file.write_text("hello")
    with pytest.raises(SystemExit) as stop:
        main(["view", str(file)])
    assert stop.value.code == 2
    assert "not a Rerun recording" in capsys.readouterr().err


@pytest.mark.parametrize(
    "command", ["demo", "identify", "convert", "view", "paper", "test hammer", "test shaker"]
)
def test_every_command_has_help_with_an_example(command, capsys):
    with pytest.raises(SystemExit) as stop:
        main([*command.split(), "--help"])
    assert stop.value.code == 0
    assert "Example" in capsys.readouterr().out
