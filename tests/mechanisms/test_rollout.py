"""The estimator's motion with mechanisms beside MuJoCo's, on any model.

On the portal the geometry alone makes 0.2 % at this force; friction's jumps 0.4 %.
"""

import numpy as np
import pytest

from twin.errors import ModelError
from twin.mechanisms import vocabulary
from twin.mechanisms.rollout import rollout
from twin.model import Twin

ALL = vocabulary()
RATE, SAMPLES = 256, 1500


def error(model, force, mechanism, outputs, newton):
    twin = Twin.load(model)
    u = newton * np.random.default_rng(3).standard_normal(SAMPLES)
    found = rollout(twin.linear([force], outputs), [mechanism], {force: u}, RATE)
    motion = twin.including(mechanism).simulate({force: u}, RATE, SAMPLES)
    true = np.column_stack([motion.column(name) for name in outputs])
    plain = rollout(twin.linear([force], outputs), [], {force: u}, RATE)
    plain, ours = (np.column_stack([c[name] for name in outputs]) for c in (plain, found))
    size = np.sqrt(np.mean(true**2))
    assert np.sqrt(np.mean((plain - true) ** 2)) > 0.03 * size, "the mechanism does nothing"
    return np.sqrt(np.mean((ours - true) ** 2)) / size


@pytest.mark.parametrize(
    ("mechanism", "limit"),
    [
        (ALL["cubic_stiffness"]("storey2_y", 1e9), 5e-3),
        (ALL["coulomb_friction"]("storey2_y", 0.05, 1e-5), 1e-2),
        (ALL["quadratic_drag"]("floor2.y", 400.0), 5e-3),
        (ALL["stiffness"]("storey1_column3_y", -300.0), 5e-3),
        (ALL["bumper"]("storey1_rz", 200.0, 5e-4), 5e-3),
        (ALL["appendage"]("floor2.y", 0.5, 3.0, 0.03), 5e-3),
    ],
)
def test_a_portal_with_a_mechanism_moves_as_in_mujoco(mechanism, limit):
    outputs = ["acc_floor1_a.x", "acc_floor1_a.y", "acc_floor2_b.y"]
    assert error("portal_3d", "force_floor2_y", mechanism, outputs, 1.0) < limit


@pytest.mark.parametrize(
    ("mechanism", "limit"),
    [
        (ALL["coulomb_friction"]("slide", 3.0, 1e-5), 1e-3),
        (ALL["quadratic_drag"]("carriage", 3000.0), 1e-4),
    ],
)
def test_a_drive_with_friction_moves_as_in_mujoco(mechanism, limit):
    assert error("drive", "force", mechanism, ["position"], 40.0) < limit


def test_what_is_random_has_no_one_motion():
    model = Twin.load("drive").linear(["force"], ["position"])
    random = ALL["unmeasured_force"]("carriage")
    with pytest.raises(ModelError, match=r"unmeasured_force at carriage is random"):
        rollout(model, [random], {"force": np.zeros(10)}, 100)
