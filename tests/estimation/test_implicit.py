"""The force of dry friction over a part of a sample, where it stops a motion or lets it go on."""

import numpy as np
import pytest
from estimation_support import FRICTION, SLIDERS

from twin.estimation.implicit import flow_slopes, solve_force
from twin.estimation.laws import addresses

FORCE, WIDTH, PART_S = 0.6, 1e-6, 1e-3
PUSH = -0.5
"""What a newton of friction adds to the rate over the part [m/(s N)]."""


def stopped(begun, pushed):
    """The force over a part that begins with a rate, and is pushed to change it; and its end."""
    law, numbers = addresses((FRICTION,))[0], np.array([FORCE, WIDTH])
    ed, v = 0.5 * PART_S * PUSH, begun + pushed
    f, *_ = solve_force(
        law, numbers.ctypes.data, 0.0, begun, 0.5 * PART_S * (begun + v), v, np.zeros(1), ed, PUSH,
        0.0, 1.0, 0.0, np.array([1.0, 0.01, 0.2, 0.0]), PART_S,
    )  # fmt: skip
    return f, v + PUSH * f


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("begun", [0.05, 0.2, 0.29])
@pytest.mark.parametrize("pushed", [-0.29, -0.2, -0.05, 0.0, 0.02])
def test_friction_stops_what_it_can_hold(begun, pushed, side):
    """Decelerating by friction and a push it is at rest within the part, and stays so."""
    brakes = pushed + PUSH * FORCE
    share = -begun / brakes
    f, end = stopped(side * begun, side * pushed)
    if share < 1 and abs(pushed) < -PUSH * FORCE:
        assert abs(end) < 20 * WIDTH
    assert side * f <= FORCE * (1 + 1e-9)


def test_friction_that_cannot_hold_acts_one_way_until_rest_and_the_other_way_then():
    begun, pushed = 0.2, -0.6
    share = begun / (-pushed - PUSH * FORCE)
    f, end = stopped(begun, pushed)
    assert f == pytest.approx(FORCE * (2 * share - 1), rel=1e-6)
    assert end < 0


STIFFNESS, YIELDS = np.array([200.0, 100.0]), np.array([0.2, 0.6])
SCALE = np.array([1.0, 0.01, 0.2])


def slopes(z, before, after):
    """Of two sliders: by memory, displacement before and after, then by the numbers, (2, 7)."""
    law, numbers = addresses((SLIDERS,))[0], np.array([*STIFFNESS, *YIELDS])
    out = np.empty((2, 7))
    flow_slopes(law, numbers, 1e-7 * numbers, np.array(z), before, after, SCALE, out)
    return out


def test_a_slider_that_slips_however_little_forgets_what_it_held():
    np.testing.assert_allclose(slopes(-YIELDS, 0.0, -1e-10)[:, :3], 0.0, atol=1e-6)
    found = slopes(-YIELDS, 0.0, -1e-6)
    np.testing.assert_allclose(found[:, :3], 0.0, atol=1e-6)
    np.testing.assert_allclose(found[:, 5:], -np.eye(2), atol=1e-6)


@pytest.mark.parametrize("z", [-YIELDS, 0.5 * YIELDS])
def test_what_does_not_move_keeps_its_memory(z):
    found = slopes(z, 0.003, 0.003)
    np.testing.assert_allclose(found[:, 0], 1.0)
    np.testing.assert_allclose(found[:, 1], -found[:, 2])  # both move: nothing does
    np.testing.assert_allclose(found[:, 3:], 0.0)
