import json

import numpy as np
import pytest

from twin.cli import main
from twin.formats import write_recording
from twin.instruments import Instrument
from twin.laboratory import Analyser, Experiment, Hammer, run
from twin.model import Twin
from twin.recording import Recording


def twin(*arguments):
    with pytest.raises(SystemExit) as stop:
        main([str(argument) for argument in arguments])
    return stop.value.code


@pytest.fixture(scope="module")
def hit():
    noisy = {kind: Instrument(noise_fraction=0.01) for kind in ("acc", "force")}
    test = Experiment(Hammer(), "floor1", Analyser(256.0, 12.0), instruments=noisy)
    return run(test, Twin.load("two_storey_lumped"), 1)


def test_a_sound_recording_is_listed_without_a_fault(hit, tmp_path, capsys):
    path = write_recording(hit, tmp_path / "hit.csv")
    assert twin("inspect", path, "--json", tmp_path / "i.json") == 0
    shown = capsys.readouterr().out
    assert "3072 samples at 256 Hz (12 s)" in shown
    assert "no faults seen" in shown
    found = json.loads((tmp_path / "i.json").read_text())
    assert [c["role"] for c in found["channels"]] == ["input", "output", "output"]
    assert found["channels"][1]["unit"] == "m/s^2"
    rms = np.sqrt(np.mean(hit.column("acc_floor2") ** 2))
    assert found["channels"][2]["rms"] == pytest.approx(rms)


def test_every_fault_is_a_line_that_names_the_channel(hit, tmp_path, capsys):
    columns = {name: hit.column(name).copy() for name in hit.names}
    time = np.arange(hit.samples) / 256
    columns["acc_floor1"] *= -1
    columns["acc_floor2"] += 0.2 * np.std(columns["acc_floor2"]) * np.sin(100 * np.pi * time) + 1
    columns["copy [m/s^2]"] = 2 * columns["acc_floor1"]
    path = write_recording(Recording.build(256.0, columns), tmp_path / "bad.csv")
    assert twin("inspect", path) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "fault: acc_floor2: hum: a line of the mains at 50" in shown
    assert "fault: acc_floor2: offset: its mean is 1" in shown
    assert "fault: acc_floor1: against force_floor1: its sign is reversed" in shown
    assert "fault: copy: against acc_floor1: is 2 times the other" in shown
    assert "acc_floor1: hum" not in shown


def test_a_file_without_units_gets_a_map_that_works(tmp_path, capsys):
    rows = "".join(f"{np.sin(i):.6f},{np.cos(i):.6f},{np.cos(2 * i):.6f}\n" for i in range(200))
    path = tmp_path / "odd.csv"
    path.write_text("Force,Acceleration1,Acceleration2\n" + rows)
    arguments = ("inspect", path, "--rate", 64, "--model", "two_storey_lumped")
    assert twin(*arguments, "--json", tmp_path / "i.json") == 0
    assert "--map 'Acceleration2=acc_floor2 [m/s^2]'" in capsys.readouterr().out
    suggested = json.loads((tmp_path / "i.json").read_text())["suggested_map"]
    assert suggested["Force"] in ("force_floor1 [N]", "force_ground [N]")
    maps = [part for c, t in suggested.items() for part in ("--map", f"{c}={t}")]
    assert twin(*arguments, *maps) == 0
    assert "acc_floor1" in capsys.readouterr().out


def test_what_cannot_be_read_is_one_line(tmp_path, capsys):
    path = tmp_path / "odd.csv"
    path.write_text("time [s],a [g]\n0,1\n1,x\n")
    assert twin("inspect", path) == 2
    assert "row 3, column 'a [g]': 'x' is not a number" in capsys.readouterr().err
