"""Scales of a motion, and where a channel's range ends."""

import numpy as np
import pytest

from twin.physics.scales import range_ends

RNG = np.random.default_rng(0)
GAUSSIAN = RNG.standard_normal(20000)


@pytest.mark.parametrize("level", [0.5, 1.0, 1.5, 2.0])
def test_the_ends_of_a_range_are_read_off_where_readings_pile_up(level):
    clipped = np.clip(GAUSSIAN, -level, level) + 0.01 * level * RNG.standard_normal(20000)
    np.testing.assert_allclose(range_ends(clipped), [-level, level], rtol=5e-3)
    np.testing.assert_allclose(range_ends(clipped + 3), [3 - level, 3 + level], rtol=5e-3)


def test_the_ends_are_those_of_the_channel_though_blows_come_from_one_side():
    blows = np.where(RNG.random(20000) < 0.1, 8.0, 0.0)
    clipped = np.clip(GAUSSIAN + blows - blows.mean(), -1.5, 1.5)
    assert abs(clipped.mean()) > 0.1
    np.testing.assert_allclose(range_ends(clipped), [-1.5, 1.5], rtol=1e-9)


def test_readings_without_an_end_have_none():
    assert range_ends(GAUSSIAN) is None
    assert range_ends(GAUSSIAN * np.exp(-np.arange(20000) / 3000)) is None


def test_one_end_alone_is_no_range():
    assert range_ends(np.minimum(GAUSSIAN, 1.0)) is None
