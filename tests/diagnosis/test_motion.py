"""Accelerations of an estimated motion, where there are few samples in a period."""

import numpy as np
import pytest

from twin.diagnosis.motion import Motion


@pytest.mark.parametrize(("samples_a_period", "error"), [(5.0, 0.01), (10.0, 1e-3), (20.0, 1e-4)])
def test_accelerations_are_of_fourth_order(samples_a_period, error):
    h = 0.03
    w = 2 * np.pi / (samples_a_period * h)
    t = h * np.arange(200)
    q, v = np.sin(w * t)[:, None], w * np.cos(w * t)[:, None]
    found = Motion(q, v, 0 * v).acceleration(h)[1:-1]
    true = -(w**2) * q[1:-1]
    assert np.max(np.abs(found - true)) < error * np.max(np.abs(true))
