"""Ten kinds of unusable data: each is said in one line that names the channel."""

import re

import numpy as np
import pytest
from tests_support import FS, analysed, noisy, one_hit, random_force

from twin.errors import IdentificationError
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


def saturated(d):
    limit = 0.8 * np.abs(d["acc_floor2"]).max()
    d["acc_floor2"] = np.clip(d["acc_floor2"], -limit, limit)


def dead(d):
    d["acc_floor2"][600:] = 0


def dropped(d):
    for k in np.random.default_rng(3).integers(100, 900, 12):
        d["acc_floor2"][k : k + 12] = d["acc_floor2"][k]


def dropped_to_zero(d):
    for k in np.random.default_rng(3).integers(100, 900, 12):
        d["acc_floor2"][k : k + 12] = 0


def another_clock(d):
    t = np.arange(len(d["acc_floor2"]))
    d["acc_floor2"] = np.interp(1.01 * t, t, d["acc_floor2"])
    for name in d:
        d[name] = d[name][:1000]


KINDS = {
    "saturated": (saturated, "acc_floor2: .* samples stand at the end of its range"),
    "reversed": (lambda d: d.update(acc_floor1=-d["acc_floor1"]), "acc_floor1: .* reversed"),
    "constant": (lambda d: d["acc_floor2"].fill(0.3), "acc_floor2 is constant at 0.3"),
    "identical": (lambda d: d.update(acc_floor2=d["acc_floor1"].copy()), "is the same signal"),
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
