import os
from pathlib import Path

import numpy as np
import pytest

from twin.errors import TwinError
from twin.laboratory.ground_motion import read_ground_motion

REAL = Path(__file__).parents[2].parent / "shared" / "data" / "ground_motion"


def written(tmp_path, text):
    path = tmp_path / "quake.csv"
    path.write_text(text)
    return path


def test_plain_columns_are_in_si_units(tmp_path):
    quake = read_ground_motion(written(tmp_path, "time,acceleration\n0,0\n0.02,1.5\n0.04,-2\n"))
    assert quake.rate_hz == 50.0
    assert np.array_equal(quake.acceleration, [0, 1.5, -2])
    assert quake.name == "quake.csv"


def test_units_in_brackets_are_converted_and_other_columns_ignored(tmp_path):
    text = "station,time [ms],acceleration [g]\n1,0,0\n2,5,0.5\n3,10,-0.1\n"
    quake = read_ground_motion(written(tmp_path, text), peak=0.3, delay_s=1.0)
    assert quake.rate_hz == pytest.approx(200.0, rel=1e-12)
    assert quake.acceleration == pytest.approx([0, 4.903325, -0.980665])
    assert (quake.peak, quake.delay_s) == (0.3, 1.0)


def test_a_recording_of_the_ground_serves_too(tmp_path):
    text = "time [s],acc_ground [m/s^2],acc_floor1 [m/s^2]\n0,0,1\n0.1,2,1\n0.2,1,1\n"
    assert np.array_equal(read_ground_motion(written(tmp_path, text)).acceleration, [0, 2, 1])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the file is empty"),
        ("time [s],speed\n0,1\n", "no unit, so nothing says what it measures"),
        ("time [s],acc_floor1 [g]\n0,1\n1,1\n", "no column 'acceleration' or 'acc_ground'"),
        ("time [s],acceleration [ft]\n0,1\n", r"unit \[ft\] is not one of acceleration"),
        ("time,acceleration\n0,1\n", "1 sample "),
        ("time,acceleration\n0,1\n1,x\n", "row 3, column 'acceleration"),
        ("time,acceleration\n0,1\nnan,1\n", "row 3, column 'time"),
        ("time,acceleration\n0,1\n1,1\n3,1\n4,2\n", "row 4: time is not uniform"),
        ("time,acceleration\n1,1\n0,1\n", "row 3: time does not increase"),
        ("time,acceleration\n0,0\n1,0\n", "zero throughout"),
    ],
)
def test_a_file_that_is_no_ground_motion_is_refused_with_its_name_and_place(
    tmp_path, text, message
):
    path = written(tmp_path, text)
    with pytest.raises(TwinError, match=f"quake.csv: .*{message}"):
        read_ground_motion(path)


def test_a_missing_or_binary_file_is_refused(tmp_path):
    with pytest.raises(TwinError, match=r"none.csv: there is no such file"):
        read_ground_motion(tmp_path / "none.csv")
    (tmp_path / "noise.csv").write_bytes(os.urandom(50) + b"\xff\xfe\x00")
    with pytest.raises(TwinError, match=r"noise.csv: "):
        read_ground_motion(tmp_path / "noise.csv")


@pytest.mark.skipif(not REAL.is_dir(), reason="the recorded earthquakes are not here")
@pytest.mark.parametrize(
    ("name", "rate_hz"),
    [("el_centro_1940", 50.0), ("kobe_1995", 100.0), ("morgan_hill_1984", 200.0)],
)
def test_recorded_earthquakes_can_be_read(name, rate_hz):
    quake = read_ground_motion(REAL / f"{name}.csv")
    assert quake.rate_hz == pytest.approx(rate_hz, rel=1e-12)
    assert 1 < np.abs(quake.acceleration).max() < 10
