"""A controlled run made by hand, and its report."""

from functools import lru_cache

import numpy as np

from twin.control.outcome import Outcome
from twin.control.plant import Plant
from twin.control.study import Settings
from twin.model import Twin
from twin.provenance import provenance
from twin.view.page.control import page

RATE, PHYSICS, SECONDS = 32.0, 128.0, 8.0


def outcome():
    """A decaying oscillation that a switch at half time calms."""
    fast, slow = (np.arange(0, SECONDS, 1 / f) for f in (PHYSICS, RATE))
    size = np.where(fast < SECONDS / 2, 1e-3, 1e-4)
    moved = np.column_stack([size * np.sin(12 * fast), 2 * size * np.sin(12 * fast)])
    return Outcome(
        RATE, PHYSICS, SECONDS / 2, ("floor1", "floor2"), moved, 0.1 * np.sin(9 * fast),
        "force_ground", np.sin(7 * fast), ("acc_floor1", "force_ground"),
        np.zeros((len(slow), 2)), 0.02 * np.sin(12 * slow), ("disp_floor1", "angle_pendulum"),
        np.column_stack([moved[::4, 0], np.zeros(len(slow))]), np.zeros((len(slow), 3)),
    )  # fmt: skip


@lru_cache(maxsize=1)
def control_page():
    plant = Plant(Twin.load("two_storey_absorber"), "force_ground", 1, 0.5)
    controller = Settings().design(plant.linear(), 1)
    ran = outcome()
    result = {
        "reduction": ran.reduction.as_json(),
        "peak_swing_rad": ran.peak_swing_rad,
        "peak_torque_nm": ran.peak_torque_nm,
        "stability_margin": 0.4,
        "controller_step_us": {"median": 6.0},
        "notes": ["the torque was at its limit in 2 samples"],
        "excitation": "force_ground",
        "delay_samples": 1,
    }
    made = provenance(["control", "--out", "lab"], [], 0)
    return page({**result, "with_true_model": result}, ran, controller, plant.linear(), made)
