import numpy as np
import pytest
from scipy import signal

from twin.control.sampled import step

A = np.array([[0.0, 1.0], [-30.0, -0.2]])
B = np.array([[0.0, 0.3], [1.0, 0.0]])


def test_held_inputs_move_the_state_as_scipy_says():
    found = step(A, B, 0.05)
    expected_A, expected_B, *_ = signal.cont2discrete((A, B, np.eye(2), np.zeros((2, 2))), 0.05)
    assert np.allclose(found.A, expected_A, rtol=1e-13)
    assert np.allclose(found.held, expected_B, rtol=1e-13)


def test_linear_inputs_move_the_state_as_scipy_says():
    found = step(A, B, 0.05)
    z, first, last = np.array([0.3, -1.0]), np.array([0.7, 2.0]), np.array([-0.4, 1.0])
    fine = np.linspace(0, 0.05, 6)
    u = first + np.outer(fine / 0.05, last - first)
    _, _, states = signal.lsim((A, B, np.eye(2), np.zeros((2, 2))), u, fine, z)
    assert found.A @ z + found.B_0 @ first + found.B_1 @ last == pytest.approx(states[-1])


def test_no_time_moves_nothing():
    found = step(A, B, 0.0)
    assert np.array_equal(found.A, np.eye(2))
    assert not found.held.any()
