import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from twin.control.lqg import lqg
from twin.control.plant import Plant
from twin.control.study import (
    Settings,
    hammer_tests,
    identified_model,
    identify_frame,
    shaken,
    step_time,
    worst_case,
)
from twin.errors import ControlError
from twin.frame import Pendulum
from twin.laboratory import Earthquake, read_ground_motion

ROOT = Path(__file__).parents[2]
GROUND_MOTIONS = ROOT.parent / "shared" / "data" / "ground_motion"


@pytest.fixture(scope="module")
def table(absorber_twin):
    return Plant(absorber_twin, "acc_ground")


def test_the_worst_case_is_on_the_plants_own_frequencies_unless_told(floor_plant, table):
    own = worst_case(floor_plant)
    assert own.frequencies == pytest.approx((1.7058, 5.7403), abs=1e-3)
    assert worst_case(floor_plant, printed=True).frequencies == (1.9, 6.8)
    assert not own.moves_the_ground
    assert worst_case(table).moves_the_ground


def test_the_hammer_model_is_the_frame_within_its_noise(floor_plant, believed):
    found = identify_frame(hammer_tests(floor_plant, seed=3))
    model = identified_model(found, Pendulum(), "force_floor1")
    for name in "MK":
        ours, true = getattr(model.structure, name), getattr(believed.structure, name)
        assert np.abs(ours - true).max() < 0.02 * np.abs(true).max()
    assert found.recordings[0].names[0] == "force_floor1"
    bare = replace(found, second_order=None, notes=("no driving point",))
    with pytest.raises(ControlError, match=r"needs M, K and R of the frame: no driving point"):
        identified_model(bare, Pendulum(), "force_floor1")


def test_a_recording_that_suggests_too_many_modes_still_gives_a_frame(floor_plant):
    """Without noise the data show more than the frame's own modes."""
    found = identify_frame(hammer_tests(floor_plant, noise=0.0))
    assert found.second_order is not None
    assert len(found.modal.natural_freq) == 2


def test_an_earthquake_is_run_from_rest_without_and_with_control(table):
    t = np.arange(300) / 50
    quake = Earthquake(np.sin(2 * np.pi * 1.7 * t) * np.sin(np.pi * t / 6), 50.0, peak=0.05)
    controller = lqg(table.linear(), ramp_s=10.0)
    outcome = shaken(table, controller, quake)
    half = round(outcome.switch_s * outcome.physics_hz)
    assert np.array_equal(outcome.excitation[:half], outcome.excitation[half:])
    assert not outcome.torque[: len(outcome.torque) // 2].any()
    assert outcome.torque[len(outcome.torque) // 2 + 1 :].any()
    assert np.abs(outcome.displacement[[0, half]]).max() < 1e-9
    assert min(outcome.reduction.whole.values()) > 0.3


def test_a_controller_step_takes_less_than_fifty_microseconds(controller):
    median, high = step_time(controller)
    assert 0 < median <= high < 50


@pytest.mark.parametrize("name", ["el_centro_1940", "kobe_1995", "morgan_hill_1984"])
def test_recorded_earthquakes_scaled_to_the_rig_are_calmed(table, name):
    path = GROUND_MOTIONS / f"{name}.csv"
    if not path.exists():
        pytest.skip(f"{path.name} is not beside the repository")
    controller = Settings().design(table.linear(), table.delay)
    outcome = shaken(table, controller, read_ground_motion(path, peak=0.14))
    assert min(outcome.reduction.whole.values()) > 0.35
    assert outcome.peak_swing_rad < 0.8
    assert not outcome.notes


def test_the_experiment_prints_the_papers_reductions_beside_ours(tmp_path):
    script = ROOT / "experiments" / "absorber_control.py"
    if not script.exists():
        pytest.skip("experiments/ is not beside the tests")
    done = subprocess.run(
        [sys.executable, script, "--only", "paper"],
        capture_output=True,
        text=True,
        check=True,
        cwd=tmp_path,
        env={**os.environ, "COLUMNS": "160", "PYTHONPATH": str(ROOT)},
    )
    assert "76.9%, 65.8%" in done.stdout
    assert "96.8%" in done.stdout
