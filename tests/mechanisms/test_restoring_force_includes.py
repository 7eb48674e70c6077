"""What a non-parametric restoring force is in itself is not offered beside it."""

import pytest

from twin.mechanisms.bumper import Bumper
from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.mechanisms.hysteresis import Hysteresis
from twin.mechanisms.restoring_force import RestoringForce


@pytest.mark.parametrize(("other", "included"), [
    (CubicStiffness("storey1", 1e5), True),
    (Bumper("storey1", 1e4, 1e-3), True),
    (CubicStiffness("storey2", 1e5), False),
    (CoulombFriction("storey1", 0.1), False),
    (Hysteresis("storey1", 100.0, 1.0), False),
])  # fmt: skip
def test_it_includes_forces_of_its_own_displacement_only(other, included):
    assert RestoringForce("storey1").includes(other) is included
