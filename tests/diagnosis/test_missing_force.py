"""The force of a law along a motion."""

import numpy as np
import pytest
from diagnosis_support import lumped, recorded, rng

from twin.diagnosis.missing_force import nonlinear_share
from twin.diagnosis.motion import Motion
from twin.diagnosis.prepare import prepare
from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.mechanisms.hysteresis import Hysteresis

SAMPLES = 20000


@pytest.fixture(scope="module")
def problem():
    train, test = recorded(lumped(), 1), recorded(lumped(), 2)
    return prepare(lumped(), [train], [test], None, 0.1, None).train


@pytest.fixture(scope="module")
def moved(problem):
    """A random motion whose drift and rate of the second storey have the deviations 1 and 1."""
    row = problem.model.port("storey2")
    draw = rng(3)
    d, v = draw.standard_normal((2, SAMPLES, 1))
    along = row / (row @ row)
    return (Motion(d * along, v * along, 0 * d * along),)


def test_a_cubic_spring_is_linear_but_for_its_known_share(problem, moved):
    # of d^3, Gaussian, the line 3 d leaves 6 of 15 of the power
    share = nonlinear_share(CubicStiffness("storey2", 2.0), problem, moved)
    assert share == pytest.approx(np.sqrt(6 / 15), rel=0.05)


@pytest.mark.parametrize("width", [1.0, 0.1, 0.01])
def test_friction_that_is_sharp_is_no_line(problem, moved, width):
    assert nonlinear_share(CoulombFriction("storey2", 3.0, width), problem, moved) > 0.2


def test_friction_that_is_wider_than_the_motion_is_fast_is_a_line(problem, moved):
    # tanh x = x - x^3 / 3, and of v^3 the line leaves sqrt(6)
    share = nonlinear_share(CoulombFriction("storey2", 3.0, 20.0), problem, moved)
    assert share == pytest.approx(np.sqrt(6) / (3 * 20.0**2), rel=0.1)


def test_the_strength_of_a_law_does_not_matter(problem, moved):
    shares = [nonlinear_share(CubicStiffness("storey2", k), problem, moved) for k in (-1e-9, 1e9)]
    assert shares[0] == pytest.approx(shares[1], rel=1e-9)


@pytest.mark.parametrize(("yield_force", "linear"), [(1e4, True), (0.3, False)])
def test_a_spring_that_does_not_yield_is_a_line(problem, yield_force, linear):
    row, t = problem.model.port("storey2"), np.arange(2000) / 100
    along = row / (row @ row)
    d, v = np.sin(t)[:, None], np.cos(t)[:, None]
    share = nonlinear_share(
        Hysteresis("storey2", 1.0, yield_force), problem, [Motion(d * along, v * along, 0 * along)]
    )
    assert share < 1e-3 if linear else share > 0.1
