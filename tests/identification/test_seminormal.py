"""Least squares by seminormal equations."""

import numpy as np
import pytest

from twin.identification.seminormal import least_squares, triangle


@pytest.mark.parametrize("angle", [1.0, 1e-3, 1e-7])
def test_two_rounds_give_what_orthogonal_factors_give(angle):
    rng = np.random.default_rng(1)
    A = rng.standard_normal((200, 6))
    A[:, 5] = A[:, 4] + angle * A[:, 5]
    A /= np.linalg.norm(A, axis=0)
    y = rng.standard_normal((200, 2))
    R = triangle(A)
    c, left = least_squares(A, R, y)
    more, left = least_squares(A, R, left)
    exact = np.linalg.lstsq(A, y, rcond=None)[0]
    np.testing.assert_allclose(left, y - A @ exact, atol=1e-9)
    np.testing.assert_allclose(A @ (c + more), A @ exact, atol=1e-9)
