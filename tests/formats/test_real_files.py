"""Recordings of real structures, as their publishers distribute them."""

from pathlib import Path

import numpy as np
import pytest

from twin.formats import read_recording

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason=f"{DATA} is missing")


def test_the_f16_ground_vibration_test_is_read():
    recording = read_recording(
        DATA / "f16_gvt" / "F16Data_FullMSine_Level1.csv",
        {
            "Force": "force_floor1 [N]",
            "Acceleration1": "acc_floor1 [m/s^2]",
            "Acceleration2": "acc_floor2 [m/s^2]",
            "Acceleration3": "acc_floor3 [m/s^2]",
        },
        400,
    )
    assert recording.samples == 9 * 8192
    assert np.std(recording.column("force_floor1")) == pytest.approx(12.4, rel=0.02)
    assert recording.data[0] == pytest.approx([0.95714, -0.018392, -0.049607, -0.046328])
    assert recording.notes == ("left out, as the channel map does not name them: 'Voltage', 'Fs'",)


@pytest.mark.parametrize("name", ["SNLS80mV", "Schroeder80mV"])
def test_the_silverbox_is_read(name):
    columns = {"V1": "force_floor1 [N]", "V2": "disp_floor1 [mm]"}
    recording = read_recording(DATA / "silverbox" / f"{name}.csv", columns, 1e7 / 2**14)
    assert recording.samples == 131072
    assert recording.duration_s == pytest.approx(214.7, abs=0.1)


def test_the_robot_arm_is_read():
    columns = {"u": "force_floor1 [N]", "y": "acc_floor1 [m/s^2]"}
    recording = read_recording(DATA / "robot_arm" / "robot_arm.csv", columns, 1)
    assert recording.samples == 1024
    assert recording.data[0] == pytest.approx([0.22183165, -0.1770363])


@pytest.mark.parametrize(
    ("name", "rate"), [("el_centro_1940", 50), ("kobe_1995", 100), ("morgan_hill_1984", 200)]
)
def test_earthquakes_are_read_with_their_own_rate(name, rate):
    columns = {"time": "time [s]", "acceleration": "acc_ground [m/s^2]"}
    recording = read_recording(DATA / "ground_motion" / f"{name}.csv", columns)
    assert recording.sampling_hz == rate
    assert recording.inputs == ("acc_ground",)
    assert 0.1 < np.abs(recording.data).max() / 9.81 < 1.5
