from dataclasses import replace

import numpy as np
import pytest
from estimation_support import two_masses

from twin.estimation.neighbours import neighbouring_gains
from twin.estimation.system import Noise, sampled


def near(stiffness, level, rms):
    system = two_masses(k=stiffness, latent=(rms, 8.0))
    plant = sampled(system, 1 / 64, 1, np.zeros(1, bool))
    start = np.diag([1e-2] * 4 + [rms**2])
    return plant, Noise(np.array([level, 0.2]), np.array([0.1, 0.2]), start)


def test_each_system_has_its_own_gains_of_as_many_samples():
    systems = [near(400.0, 0.3, 0.5), near(450.0, 0.3, 0.4), near(400.0, 0.3, 0.5)]
    gain, innovation = neighbouring_gains(systems, 20, None)
    assert gain.shape == (21, 7, 2, 3)
    assert innovation.shape == (21, 2, 2, 3)
    assert np.array_equal(gain[..., 0], gain[..., 2])
    assert np.array_equal(innovation[..., 0], innovation[..., 2])
    assert not np.allclose(gain[..., 0], gain[..., 1])


def test_one_without_a_stationary_filter_is_said():
    plant, noise = near(400.0, 0.3, 0.5)
    blind = replace(plant.system, C=0 * plant.system.C)
    lost = replace(plant, whole=1.1 * plant.whole, system=blind)
    with pytest.raises(ValueError, match="no stationary solution"):
        neighbouring_gains([(plant, noise), (lost, noise)], 20, None)
