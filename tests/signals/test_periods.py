import numpy as np
import pytest

from twin.errors import RecordingError
from twin.recording import Recording
from twin.signals.periods import last_periods, mean_period


def numbered(periods, period=10):
    force = np.tile(np.arange(period, dtype=float), periods)
    acc = force + 100 * np.repeat(np.arange(periods), period)
    return Recording.build(1.0, {"force_floor1": force, "acc_floor1": acc})


def test_the_mean_period_leaves_out_the_first_and_the_unseen_ones():
    mean = mean_period(numbered(6), 10, unseen=2)
    assert mean.samples == 10
    np.testing.assert_allclose(mean.column("acc_floor1"), np.arange(10) + 200)
    assert "periods 2 to 4" in mean.notes[-1]


def test_two_periods_are_both_used():
    np.testing.assert_allclose(
        mean_period(numbered(2), 10).column("acc_floor1"), np.arange(10) + 50
    )


def test_the_last_periods_are_returned_as_they_are():
    kept = last_periods(numbered(6), 10, 2)
    assert kept.samples == 20
    assert kept.column("acc_floor1")[0] == 400
    assert kept.start_s == 40


def test_too_few_periods_are_refused():
    with pytest.raises(RecordingError, match="25 samples hold 2 periods of 10; 2 unseen"):
        mean_period(numbered(3).trim(0, 25), 10, unseen=2)
