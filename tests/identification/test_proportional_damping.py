"""Proportional damping, eqs. (42)-(46)."""

import numpy as np
import pytest

from twin.errors import IdentificationError
from twin.identification.proportional_damping import proportional_damping
from twin.second_order import SecondOrderModel

M = np.array([[2.0, -0.1, 0.0], [-0.1, 1.0, 0.0], [0.0, 0.0, 0.5]])
K = np.array([[900.0, -400.0, 0.0], [-400.0, 700.0, -300.0], [0.0, -300.0, 300.0]])


def test_the_coefficients_of_a_proportionally_damped_structure_come_back():
    modes = SecondOrderModel(M, 0.2 * M + 3e-5 * K, K, ("a", "b", "c")).modes()
    alpha, beta = proportional_damping(modes.natural_freq, modes.damping_ratio)
    assert alpha == pytest.approx(0.2, rel=1e-9)
    assert beta == pytest.approx(3e-5, rel=1e-9)


def test_two_modes_are_met_exactly():
    freq, zeta = np.array([1.912, 6.847]), np.array([0.0118, 0.0039])
    alpha, beta = proportional_damping(freq, zeta)
    omega = 2 * np.pi * freq
    np.testing.assert_allclose((alpha / omega + beta * omega) / 2, zeta, rtol=1e-12)


def test_three_modes_are_met_in_the_least_squares_sense():
    freq, zeta = np.array([1.0, 3.0, 8.0]), np.array([0.02, 0.01, 0.03])
    omega = 2 * np.pi * freq
    pseudoinverse = np.linalg.pinv(0.5 * np.column_stack([1 / omega, omega]))
    np.testing.assert_allclose(proportional_damping(freq, zeta), pseudoinverse @ zeta, rtol=1e-9)


def test_frequencies_far_apart_do_not_lose_a_coefficient():
    freq = np.array([1e-4, 1e6])
    omega = 2 * np.pi * freq
    zeta = (0.3 / omega + 1e-9 * omega) / 2
    np.testing.assert_allclose(proportional_damping(freq, zeta), [0.3, 1e-9], rtol=1e-6)


@pytest.mark.parametrize(
    ("freq", "zeta", "message"),
    [
        ([2.0], [0.01], "two different natural frequencies, got 1"),
        ([2.0, 2.0], [0.01, 0.01], "two different natural frequencies, got 1"),
        ([2.0, 3.0], [0.01], "got 1 for 2"),
        ([2.0, -3.0], [0.01, 0.01], "positive natural frequencies"),
        ([2.0, 3.0], [0.01, np.nan], "finite damping ratios"),
    ],
)
def test_what_cannot_be_fitted_is_refused(freq, zeta, message):
    with pytest.raises(IdentificationError, match=message):
        proportional_damping(freq, zeta)
