"""What the text allows of (60)."""

from itertools import groupby, pairwise

import numpy as np
import pytest
from scipy import linalg

from twin.paper.reduction import reductions


def test_the_ceiling_does_not_depend_on_the_controller_and_no_controller_passes_it():
    for _, cases in groupby(reductions(), key=lambda case: (case.excited, case.noise_std)):
        cases = list(cases)
        assert len({case.torque_weight for case in cases}) == len(cases) == 3
        assert len({case.ceiling for case in cases}) == 1
        for case in cases:
            assert np.all(np.array(case.whole) <= np.array(case.ceiling) + 1e-12)


def test_cheaper_torque_reduces_more_and_swings_the_pendulum_further():
    for _, cases in groupby(reductions(), key=lambda case: (case.excited, case.noise_std)):
        cases = sorted(cases, key=lambda case: case.torque_weight)
        for cheap, dear in pairwise(cases):
            assert np.all(np.array(cheap.steady) > np.array(dear.steady))
            assert cheap.peak_swing > dear.peak_swing
        assert cases[0].peak_swing < np.pi / 2


def test_one_case_by_stepping_the_equations_of_motion():
    m, half = 0.083, 0.0825
    M, R, K = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    M[:2, :2] = [[1.3005, -0.0846], [-0.0846, 0.5663]]
    M[1:, 1:] += [[m, m * half], [m * half, m * half**2 + 8.32e-4]]
    R[:2, :2] = [[0.3955, -0.0485], [-0.0485, 0.1838]]
    K[:2, :2] = [[1047.3, -824.1], [-824.1, 841.6]]
    K[2, 2] = m * 9.81 * half
    forces = np.linalg.solve(M, [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]])
    A = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.linalg.solve(M, np.hstack([K, R]))]])
    B = np.vstack([np.zeros((3, 2)), forces])
    step = linalg.expm(np.block([[A, B], [np.zeros((2, 8))]]) / 32)
    Ad, Bf, Bc = step[:6, :6], step[:6, 6], step[:6, 7:]
    Q = np.diag([1.0, 1, 0, 0, 0, 0])
    P = linalg.solve_discrete_are(Ad, Bc, Q, [[0.1]])
    F = np.linalg.solve(Bc.T @ P @ Bc + 0.1, Bc.T @ P @ Ad)
    t = np.arange(2048) / 32
    force = 0.1 * np.sin(2 * np.pi * 1.9 * t) + 0.1 * np.sin(2 * np.pi * 6.8 * t)
    z, motion = np.zeros(6), []
    for k in range(2048):
        motion.append(np.abs(z[:2]))
        z = (Ad - Bc @ F if k >= 1024 else Ad) @ z + Bf * force[k]
    x = np.array(motion)
    (case,) = (
        c
        for c in reductions()
        if (c.excited, c.noise_std, c.torque_weight) == ("floor 1", 0.0, 0.1)
    )
    before = x[:1024].max(axis=0)
    assert case.whole == pytest.approx(1 - x[1024:].max(axis=0) / before, rel=1e-6)
    assert case.steady == pytest.approx(1 - x[1536:].max(0) / x[512:1024].max(0), rel=1e-6)
    assert case.ceiling == pytest.approx(1 - x[1024] / before, rel=1e-6)
