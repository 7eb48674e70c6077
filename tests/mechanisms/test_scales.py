"""Scales of a motion, and where a channel's range ends."""

from types import SimpleNamespace

import numpy as np
import pytest

from twin import mechanisms
from twin.mechanisms.scales import range_ends

GAUSSIAN = np.random.default_rng(0).standard_normal(20000)


@pytest.mark.parametrize(("level", "error"), [(0.5, 5e-3), (1.0, 5e-3), (1.5, 5e-3), (2.0, 1e-2)])
def test_the_ends_of_a_range_are_read_off_where_readings_pile_up(level, error):
    """Where few readings pile up, those of the motion beside them draw the end inwards."""
    noise = 0.01 * level * np.random.default_rng(1).standard_normal(20000)
    clipped = np.clip(GAUSSIAN, -level, level) + noise
    np.testing.assert_allclose(range_ends(clipped), [-level, level], rtol=error)
    np.testing.assert_allclose(range_ends(clipped + 3), [3 - level, 3 + level], rtol=error)


def test_the_ends_are_those_of_the_channel_though_blows_come_from_one_side():
    blows = np.where(np.random.default_rng(2).random(20000) < 0.1, 8.0, 0.0)
    clipped = np.clip(GAUSSIAN + blows - blows.mean(), -1.5, 1.5)
    assert abs(clipped.mean()) > 0.1
    np.testing.assert_allclose(range_ends(clipped), [-1.5, 1.5], rtol=1e-9)


def test_a_level_that_is_read_off_is_all_but_known():
    clips = mechanisms.vocabulary()["sensor_clipping"]
    for reading, known in ((np.clip(GAUSSIAN, -1.5, 1.5), True), (GAUSSIAN, False)):
        (start,) = clips.starts("acc_floor1", SimpleNamespace(reading=reading))
        assert start.level == pytest.approx(1.5 if known else np.abs(GAUSSIAN).max(), rel=1e-9)
        assert ("level" in start.priors()) is known
    mean, std = clips("acc_floor1", 1.4, 1.5).priors()["level"]
    assert mean == pytest.approx(np.log(1.5))
    assert 0 < std < 0.01


def test_readings_without_an_end_have_none():
    assert range_ends(GAUSSIAN) is None
    assert range_ends(GAUSSIAN * np.exp(-np.arange(20000) / 3000)) is None


def test_one_end_alone_is_no_range():
    assert range_ends(np.minimum(GAUSSIAN, 1.0)) is None
