from dataclasses import replace

import numpy as np
import pytest
from estimation_support import two_masses
from scipy.linalg import solve_discrete_are

from twin.errors import NoLikelihoodError
from twin.estimation.kalman import LONGEST_START, SAME, gains
from twin.estimation.system import Noise, sampled


def setting(latent=None):
    system = two_masses(latent=latent)
    plant = sampled(system, 1 / 64, 2, np.zeros(1, bool))
    start = np.diag([1e-2] * 4 + [1.0] * (len(plant.A) - 4))
    return plant, Noise(np.array([0.3, 0.2]), np.array([0.1, 0.2]), start)


def test_after_a_blow_the_gains_are_those_of_a_plain_kalman_filter_that_knows_less():
    plant, noise = setting()
    late, moved = 300, np.array([0.0, 0.0, 0.3, -0.1])
    kicks = {late: np.outer(moved, moved), 5: 1e-3 * np.eye(4)}
    found = gains(plant, replace(noise, kicks=kicks))
    A, C = plant.whole, plant.system.C
    W, V = plant.entry * noise.held, plant.system.V * noise.held
    P = noise.start
    assert len(found.state) > late + 3
    for k in range(len(found.state) - 1):
        P = P + kicks.get(k, 0.0)
        S = C @ P @ C.T + V @ V.T + np.diag(noise.output**2)
        np.testing.assert_allclose(found.innovation[k], S, atol=2 * SAME * np.max(S))
        K = (A @ P @ C.T + W @ V.T) @ np.linalg.inv(S)
        P = A @ P @ A.T + W @ W.T + plant.Q - K @ S @ K.T
    without = gains(plant, noise)
    assert np.max(found.innovation[late]) > 1.5 * np.max(without.innovation[-1])
    np.testing.assert_allclose(found.innovation[-1], without.innovation[-1], rtol=1e-12)


@pytest.mark.parametrize("latent", [None, (0.5, 8.0)])
def test_the_stationary_gain_solves_the_riccati_equation_with_cross_covariance(latent):
    plant, noise = setting(latent)
    gain = gains(plant, noise, first=0)
    W, V = plant.entry * noise.held, plant.system.V * noise.held
    Q, R, S = W @ W.T + plant.Q, V @ V.T + np.diag(noise.output**2), W @ V.T
    P = solve_discrete_are(plant.whole.T, plant.system.C.T, Q, R, s=S)
    assert gain.predicted == pytest.approx(P, rel=1e-7, abs=1e-10)
    innovation = plant.system.C @ P @ plant.system.C.T + R
    assert gain.innovation[-1] == pytest.approx(innovation, rel=1e-7)
    whole = plant.whole @ gain.state[-1] + plant.entry @ gain.held[-1]
    expected = (plant.whole @ P @ plant.system.C.T + S) @ np.linalg.inv(innovation)
    assert whole == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_the_gains_from_an_unknown_state_are_those_of_a_plain_kalman_filter():
    plant, noise = setting()
    found = gains(plant, noise)
    A, C = plant.whole, plant.system.C
    W, V = plant.entry * noise.held, plant.system.V * noise.held
    P = noise.start
    assert 3 < len(found.state) <= LONGEST_START + 1
    for k in range(len(found.state) - 1):
        S = C @ P @ C.T + V @ V.T + np.diag(noise.output**2)
        K = (A @ P @ C.T + W @ V.T) @ np.linalg.inv(S)
        assert found.innovation[k] == pytest.approx(S, rel=1e-6)
        assert A @ found.state[k] + plant.entry @ found.held[k] == pytest.approx(
            K, rel=1e-6, abs=1e-9
        )
        P = A @ P @ A.T + W @ W.T + plant.Q - K @ S @ K.T
    last = C @ P @ C.T + V @ V.T + np.diag(noise.output**2)
    assert last == pytest.approx(found.innovation[-1], abs=2 * SAME * np.max(last))


def test_no_stationary_filter_is_said():
    plant, noise = setting()
    blind = replace(
        plant, whole=1.1 * plant.whole, system=replace(plant.system, C=np.zeros((2, 4)))
    )
    with pytest.raises(NoLikelihoodError, match="no stationary solution"):
        gains(blind, noise)


def test_outputs_without_any_noise_are_said():
    plant, noise = setting()
    sure = replace(noise, held=0 * noise.held, output=0 * noise.output, start=0 * noise.start)
    with pytest.raises(np.linalg.LinAlgError, match="singular"):
        gains(replace(plant, Q=0 * plant.Q), sure)
