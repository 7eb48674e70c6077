"""Least squares by seminormal equations."""

import numpy as np
import pytest

from twin.identification.seminormal import covariance_of, least_squares, triangle


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


def test_what_has_no_information_is_unknown_and_the_rest_as_known_as_ever():
    J = np.random.default_rng(2).standard_normal((50, 3)) * [1e-3, 1, 1e6]
    known = np.linalg.inv(J.T @ J)
    J = np.column_stack([J, J[:, 0] * 0, J[:, 1]])
    found = covariance_of(J.T @ J)
    np.testing.assert_allclose(found[np.ix_([0, 2], [0, 2])], known[np.ix_([0, 2], [0, 2])], 1e-6)
    for vague in (1, 3, 4):
        assert found[vague, vague] > 1e9 * known[1, 1]
