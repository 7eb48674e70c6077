"""Small helpers for arrays."""

import numpy as np

from twin.arrays import strongest


def test_the_strongest_part_is_where_the_inputs_have_most_power():
    u = np.zeros((100, 2))
    u[40:50, 0], u[42:44, 1], u[90, 0] = 1.0, 1e-3, 2.0
    assert strongest(u, 10) == slice(40, 50)
    assert strongest(u, 100) == slice(0, 100)
