"""Ten kinds of unusable data: each is said in one line that names the channel."""

import re

import numpy as np
import pytest
from spoilt_support import (
    another_clock,
    constant,
    dead,
    dropped,
    dropped_to_zero,
    identical,
    in_g,
    reversed_at_the_force,
    saturated,
)
from tests_support import FINE, FS, SECONDS, analysed, noisy, one_hit, random_force

from twin.cli import main
from twin.errors import IdentificationError
from twin.formats import write_recording
from twin.identification.doubts import doubts_of_band, doubts_of_data
from twin.identification.identify import identify
from twin.recording import Recording

CHANNELS = ("force_floor1", "acc_floor1", "acc_floor2")


def columns(frame, forces):
    recording = noisy(analysed(frame, forces, 32, 32), 0.01, 0)
    return {name: recording.column(name).copy() for name in CHANNELS}


@pytest.fixture(scope="module")
def hit(frame):
    return columns(frame, one_hit())


@pytest.fixture(scope="module")
def shaken(frame):
    return columns(frame, random_force())


def doubts(data):
    return doubts_of_data([Recording.build(FS, data, source="x.csv")], CHANNELS[:1], CHANNELS[1:])


KINDS = {
    "saturated": (saturated, "acc_floor2: .* samples stand at the end of its range"),
    "reversed": (reversed_at_the_force, "acc_floor1: .* reversed"),
    "constant": (constant, "acc_floor2 is constant at 0.3"),
    "identical": (identical, "is the same signal"),
    "dead tail": (dead, "acc_floor2: it stands still from sample 601 to the end"),
    "dropouts": (dropped, "acc_floor2: .* repeat the one before"),
    "dropouts to zero": (dropped_to_zero, "acc_floor2: .* repeat the one before"),
    "clock": (another_clock, "acc_floor2: against acc_floor1 its clock is off by about 1 %"),
}


@pytest.mark.parametrize("source", ["hit", "shaken"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_spoilt_channel_is_named_in_one_line(kind, source, request):
    spoil, said = KINDS[kind]
    data = {n: x.copy() for n, x in request.getfixturevalue(source).items()}
    assert doubts(data) == []
    spoil(data)
    lines = doubts(data)
    assert len(lines) == 1
    assert re.search(said, lines[0])
    assert lines[0].startswith("warning: x.csv")


def test_a_band_without_force_is_said(shaken):
    u = [shaken["force_floor1"][:, None]]
    assert doubts_of_band(u, 1 / FS, None, "x") == []
    assert doubts_of_band(u, 1 / FS, (1.0, 8.0), "x") == []
    (line,) = doubts_of_band(u, 1 / FS, (13.0, 15.9), "x")
    assert "the input excites" in line


def test_a_constant_force_gives_no_modes(hit):
    with pytest.raises(IdentificationError, match="force_floor1 is constant"):
        identify([Recording.build(FS, hit | {"force_floor1": np.ones(1024)}, source="x")])


def test_readings_in_g_are_said(hit):
    recording = Recording.build(FS, hit | {"acc_floor2": hit["acc_floor2"] / 9.81}, source="x")
    found = identify([recording])
    assert "mass at floor2 comes out" in found.notes[1]
    assert found.notes[1].startswith("warning: acc_floor2")


def test_a_sensor_that_is_reversed_away_from_the_force_is_said(hit):
    found = identify([Recording.build(FS, hit | {"acc_floor2": -hit["acc_floor2"]}, source="x")])
    assert found.notes[0].startswith("warning: acc_floor2: moves against the others")


def test_good_data_raise_no_doubt(hit):
    found = identify([Recording.build(FS, hit, source="x")])
    assert not [n for n in found.notes if n.startswith("warning")]


def sine(frame):
    t = np.arange(int(SECONDS * FS * FINE)) / (FS * FINE)
    return columns(frame, {"force_floor1": 3 * np.sin(2 * np.pi * 2.3 * t)})


AT_THE_COMMAND_LINE = {
    "saturated": saturated, "reversed": reversed_at_the_force, "constant": constant,
    "identical": identical, "dead tail": dead, "dropouts": dropped, "unit": in_g,
    "clock": another_clock,
}  # fmt: skip


def command(capsys, monkeypatch, tmp_path, data, *options):
    monkeypatch.setattr("twin.view.report.write_identification", lambda *_, **__: [])
    monkeypatch.setenv("COLUMNS", "60")
    file = tmp_path / "spoilt.csv"
    write_recording(Recording.build(FS, data, source="spoilt.csv"), file)
    with pytest.raises(SystemExit) as stop:
        main(["identify", str(file), "--out", str(tmp_path / "o"), *options])
    return stop.value.code, capsys.readouterr()


def said_before_the_modes(code, printed):
    """One line each, before the modes or instead of them."""
    if code:
        assert code == 2
        assert len(printed.err.strip().splitlines()) == 1
        return [printed.err]
    lines = printed.out.splitlines()
    modes = next(i for i, line in enumerate(lines) if line.strip() == "Modes")
    assert not [line for line in lines[modes:] if "warning" in line]
    return [line for line in lines[:modes] if line.startswith("warning: ")]


@pytest.mark.parametrize("kind", AT_THE_COMMAND_LINE)
def test_the_command_says_it_before_the_modes(kind, shaken, capsys, monkeypatch, tmp_path):
    data = {n: x.copy() for n, x in shaken.items()}
    AT_THE_COMMAND_LINE[kind](data)
    assert said_before_the_modes(*command(capsys, monkeypatch, tmp_path, data))


def test_the_command_says_that_a_sine_cannot_tell(frame, capsys, monkeypatch, tmp_path):
    lines = said_before_the_modes(*command(capsys, monkeypatch, tmp_path, sine(frame)))
    assert any("cannot be told" in line for line in lines)


def test_the_command_says_that_the_band_is_not_excited(shaken, capsys, monkeypatch, tmp_path):
    done = command(capsys, monkeypatch, tmp_path, shaken, "--band", "13", "15.9")
    assert said_before_the_modes(*done)


def test_the_command_has_no_doubt_of_good_data(shaken, capsys, monkeypatch, tmp_path):
    assert said_before_the_modes(*command(capsys, monkeypatch, tmp_path, shaken)) == []
