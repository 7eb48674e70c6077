"""Real structures: what is known of them must come out."""

from pathlib import Path

import numpy as np
import pytest

from twin.formats import read_recording
from twin.identification.identify import identify
from twin.identification.unseen import unseen_nrmse
from twin.signals.periods import last_periods, mean_period

DATA = Path(__file__).parents[2].parent / "shared" / "data"
F16 = DATA / "f16_gvt" / "F16Data_FullMSine_Level1.csv"
ARM = DATA / "robot_arm" / "robot_arm.csv"

needs_f16 = pytest.mark.skipif(not F16.exists(), reason=f"the F-16 recording is not at {F16}")
needs_arm = pytest.mark.skipif(not ARM.exists(), reason=f"the robot arm's is not at {ARM}")


@needs_f16
def test_the_f16_has_its_known_modes_and_unseen_periods_are_explained():
    names = {"Force": "force_floor1 [N]"}
    names |= {f"Acceleration{i}": f"acc_floor{i} [m/s^2]" for i in (1, 2, 3)}
    recording = read_recording(F16, names, 400.0)
    found = identify([mean_period(recording, 8192, unseen=3)])
    for known in (5.2, 7.3, 9.2):
        assert np.min(np.abs(found.modal.natural_freq - known)) < 0.06
    assert np.all(found.modal.damping_ratio > 0)
    assert np.all(found.modal.natural_freq_std < 0.02)
    assert unseen_nrmse(found, last_periods(recording, 8192, 3)) < 0.15


@needs_arm
def test_the_robot_arm_is_explained_beyond_what_was_fitted():
    names = {"u": "force_floor1 [N]", "y": "acc_floor1 [m/s^2]"}
    recording = read_recording(ARM, names, 1.0)
    found = identify([recording.trim(0, 700)])
    assert unseen_nrmse(found, recording.trim(700, 1024)) < 0.05
