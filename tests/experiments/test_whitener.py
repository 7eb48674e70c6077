"""The whitener against the dense covariance of the noise."""

import numpy as np
import pytest
from scipy.signal import dimpulse

from experiments.concealed.rig import TWO_STOREY
from experiments.concealed.whitener import Whitener, noise_path


@pytest.mark.parametrize("floor", [0, 1, 2])
@pytest.mark.parametrize("channels", [[0], [0, 1]])
def test_the_squared_length_is_that_of_the_dense_covariance(floor, channels):
    samples, step_s, driven, own = 200, 1 / 64, 0.03, np.array([0.01, 0.02])[: len(channels)]
    system = noise_path(TWO_STOREY, floor, np.array(channels), step_s)
    _, response = dimpulse((*system, step_s), n=samples)
    m = len(channels)
    G = np.zeros((samples, m, samples))
    for k in range(samples):
        G[k:, :, k] = response[0][: samples - k]
    G = G.reshape(samples * m, samples)
    covariance = driven**2 * G @ G.T + np.diag(np.tile(own**2, samples))
    y = np.random.default_rng(1).standard_normal((samples, m))
    white = Whitener.of_noise(*system, driven, own, samples).of(y)
    wanted = y.ravel() @ np.linalg.solve(covariance, y.ravel())
    assert np.sum(white**2) == pytest.approx(wanted, rel=1e-8)


def test_floors_follow_a_slowly_shaken_ground_and_no_fast_one():
    A, B, C, D = noise_path(TWO_STOREY, 0, np.array([0, 1]), 1e-5)
    np.testing.assert_allclose(D.ravel(), 0.0, atol=1e-3)
    steady = C @ np.linalg.solve(np.eye(len(A)) - A, B) + D
    np.testing.assert_allclose(steady.ravel(), 1.0, rtol=1e-6)
