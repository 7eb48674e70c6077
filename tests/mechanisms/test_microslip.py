"""Slip that begins at any displacement, against the laws of Ramberg and Osgood, and of Masing."""

import numpy as np
import pytest

from twin.estimation.laws import memory_along
from twin.mechanisms.microslip import FARTHEST, RATIO, SLIDERS, Microslip

REACH, K = 0.004, 300.0


def along(law, drift):
    return law.force(drift, 0.0, memory_along(law.compiled, np.array(law.numbers), drift), 0.0)


def first_loading(d, softening):
    return K * REACH * (d / REACH) ** (1 / (1 + softening))


@pytest.mark.parametrize("softening", [0.1, 0.5, 1.0, 2.0])
def test_it_loads_with_a_power_of_the_drift(softening):
    law = Microslip("storey1", K, softening, 0.0, REACH)
    drift = np.concatenate([[0.0], np.geomspace(REACH / 100, FARTHEST * REACH, 400)])
    found, true = along(law, drift)[1:], first_loading(drift[1:], softening)
    assert np.max(np.abs(found / true - 1)) < 0.01


def test_nothing_softens_where_the_power_is_one():
    law = Microslip("storey1", K, 1e-9, 0.0, REACH)
    drift = REACH * np.sin(np.linspace(0, 12, 500))
    np.testing.assert_allclose(along(law, drift), K * drift, atol=1e-6 * K * REACH)


def test_a_loop_is_the_curve_of_first_loading_twice_as_large():
    law = Microslip("storey1", K, 1.0, 0.0, REACH)
    up = np.linspace(0, REACH, 801)
    drift = np.concatenate([up, up[-2::-1], -up[1:]])
    force = along(law, drift)
    back = drift[800:]
    tip, half = force[800], along(law, (drift[800] - back) / 2)
    np.testing.assert_allclose(force[800:], tip - 2 * half, atol=1e-9 * tip)


def test_it_remembers_every_reversal_that_is_still_open():
    law = Microslip("storey1", K, 1.0, 0.0, REACH)
    way = np.array([0.0, 1.0, -0.8, 0.5, -0.2, 0.5, -0.8, 1.0]) * REACH
    force = along(law, way)
    # inner loops close where they began, and leave the outer one as if they had not been
    assert force[5] == pytest.approx(force[3])
    assert force[6] == pytest.approx(force[2])
    assert force[7] == pytest.approx(force[1])


def test_a_cycle_loses_what_loops_on_a_power_lose():
    """Of Masing's loops on f ~ d^a the loss is 4 f d (1 - a) / (1 + a), with f and d of the tip."""
    for softening in (0.3, 1.0):
        law = Microslip("storey1", K, softening, 0.0, REACH)
        turn = np.linspace(0, 2 * np.pi, 4001)
        drift = np.concatenate([np.linspace(0, REACH, 1000), REACH * np.cos(turn[1:])])
        force = along(law, drift)
        loss = np.trapezoid(force[999:], drift[999:])
        a = 1 / (1 + softening)
        assert loss / (4 * K * REACH**2) == pytest.approx((1 - a) / (1 + a), rel=0.05)


def test_it_takes_over_the_spring_it_replaces():
    law = Microslip("storey1", K, 0.5, K, REACH)
    bare, taken = law.parted()
    assert taken == -K
    drift = REACH * np.sin(np.linspace(0, 9, 300))
    np.testing.assert_allclose(along(bare, drift) + taken * drift, along(law, drift))


def test_its_corners_are_as_many_as_it_remembers():
    stiffness, drifts = np.array(Microslip("storey1", K, 0.5, 0.0, REACH).sliders()).T
    assert len(drifts) == SLIDERS == Microslip.memory
    assert np.all(stiffness > 0)
    np.testing.assert_allclose(drifts[1:] / drifts[:-1], RATIO)
    assert drifts[-1] == pytest.approx(FARTHEST * REACH)
