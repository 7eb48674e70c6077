"""Dampings that go with the modes: their ratios stay, whatever masses and stiffnesses become."""

import numpy as np
from scipy.linalg import eigh

from twin.diagnosis.modal_damping import following, modes_of


def frame(masses, springs):
    M = np.diag(masses)
    a, b, c = springs
    return M, np.array([[a + b, -b, 0.0], [-b, b + c, -c], [0.0, -c, c]])


NOMINAL = frame([1.0, 2.0, 1.5], [500.0, 400.0, 300.0])
RATIOS = np.array([0.02, 0.005, 0.011])


def followed(M0, K0, M, K, D):
    return following(M0, modes_of(M0, K0), M, K, D)


def damped(M, K, ratios):
    """M Phi diag(2 zeta w) Phi' M, the textbook's matrix."""
    squares, shapes = eigh(K, M)
    return M @ shapes @ np.diag(2 * ratios * np.sqrt(squares)) @ shapes.T @ M


def test_modal_ratios_are_kept_exactly():
    built = frame([1.3, 1.6, 1.7], [430.0, 520.0, 260.0])
    found = followed(*NOMINAL, *built, damped(*NOMINAL, RATIOS))
    np.testing.assert_allclose(found, damped(*built, RATIOS), rtol=1e-9, atol=1e-9)


def test_nothing_moved_changes_nothing_not_even_dashpots_that_couple_modes():
    D = damped(*NOMINAL, RATIOS) + np.diag([0.0, 0.8, 0.0])
    np.testing.assert_allclose(followed(*NOMINAL, *NOMINAL, D), D, rtol=1e-9, atol=1e-12)


def test_modes_that_change_places_keep_their_own_ratios():
    """Two pendulums side by side: the one that was the slower becomes the faster."""
    M, D = np.eye(2), np.diag([2 * 0.03 * 10.0, 2 * 0.01 * 11.0])
    found = followed(M, np.diag([100.0, 121.0]), M, np.diag([144.0, 121.0]), D)
    np.testing.assert_allclose(found, np.diag([2 * 0.03 * 12.0, 2 * 0.01 * 11.0]), rtol=1e-12)


def test_a_structure_that_floats_keeps_the_damping_of_its_rigid_mode():
    K = np.array([[300.0, -300.0], [-300.0, 300.0]])
    M, D = np.diag([1.0, 2.0]), 0.3 * np.ones((2, 2))
    found = followed(M, K, M, 1.44 * K, D)
    together = np.ones(2)
    assert np.isclose(together @ found @ together, together @ D @ together, rtol=1e-9)


def test_the_change_is_smooth():
    def at(x):
        built = frame([1.0 + 0.1 * x, 2.0, 1.5 - 0.2 * x], [500.0, 400.0 + 60 * x, 300.0])
        return followed(*NOMINAL, *built, damped(*NOMINAL, RATIOS))

    slope = at(1e-4) - at(0.0)
    np.testing.assert_allclose(at(0.0) - at(-1e-4), slope, rtol=1e-2, atol=1e-9)
