"""The frame with a pendulum: energy, and the small motion's frequencies, by other equations."""

import numpy as np
import pytest
from scipy.linalg import eigh

from experiments.concealed.absorber_rig import GRAVITY, Absorber, ControlledRig
from experiments.concealed.rig import TWO_STOREY, Rig

STILL = Rig(TWO_STOREY.masses, TWO_STOREY.stiffnesses, (0.0, 0.0))
FREE = Absorber(damping=0.0)
STEP_S = 1 / 4096


def energy(states, one=FREE):
    """Kinetic energy of floors and of the pendulum's mass and spin, springs, and height."""
    x, a, v, w = states[:, :2], states[:, 2], states[:, 3:5], states[:, 5]
    own = one.inertia - one.mass * one.distance**2
    across = v[:, 1] + one.distance * w * np.cos(a)
    up = one.distance * w * np.sin(a)
    kinetic = v**2 @ np.array(STILL.masses) + one.mass * (across**2 + up**2) + own * w**2
    springs = np.einsum("ki,ij,kj->k", x, STILL.stiffness, x)
    return (kinetic + springs) / 2 - one.mass * GRAVITY * one.distance * np.cos(a)


def test_a_wide_swing_keeps_its_energy():
    rig = ControlledRig(STILL, FREE, 1, STEP_S)
    rig.state = np.array([2e-3, -1e-3, 1.2, 0.05, 0.0, -2.0])
    states, _ = rig.run(np.zeros(8193), np.zeros(8192))
    found = energy(states)
    assert np.ptp(found) < 1e-9 * np.ptp(states[:, 2]) + 1e-8
    assert np.ptp(states[:, 2]) > 1.0


def test_accelerations_are_the_rates_of_the_rates():
    rig = ControlledRig(TWO_STOREY, Absorber(friction=1e-4), 2, STEP_S)
    force = 0.2 * np.sin(np.arange(4097) / 300)
    states, seen = rig.run(force, np.full(4096, 1e-3))
    slope = np.gradient(states[:, 3:], STEP_S, axis=0)
    assert np.abs(slope[2:-2] - seen[2:-2]).max() < 2e-3 * np.abs(seen).max()


def test_a_small_motion_has_the_linear_frequencies():
    one, floors = FREE, np.array(STILL.masses)
    M, K = np.zeros((3, 3)), np.zeros((3, 3))
    M[:2, :2], K[:2, :2] = np.diag(floors), STILL.stiffness
    M[1, 1] += one.mass
    M[1, 2] = M[2, 1] = one.mass * one.distance
    M[2, 2], K[2, 2] = one.inertia, one.mass * GRAVITY * one.distance
    squares, shapes = eigh(K, M)
    rig = ControlledRig(STILL, one, 1, STEP_S)
    rig.state = np.concatenate([1e-6 * shapes[:, 1], np.zeros(3)])
    states, _ = rig.run(np.zeros(4097), np.zeros(4096))
    wanted = np.cos(np.sqrt(squares[1]) * STEP_S * np.arange(4096))
    assert states[:, 2] / states[0, 2] == pytest.approx(wanted, abs=1e-5)
