from dataclasses import replace

import numpy as np
import pytest
from estimation_support import two_masses

from twin.errors import NoLikelihoodError
from twin.estimation.kalman import EquivalentLinear, gains
from twin.estimation.neighbours import neighbouring_gains
from twin.estimation.system import Noise, sampled


def near(stiffness, level, rms):
    system = two_masses(k=stiffness, latent=(rms, 8.0))
    plant = sampled(system, 1 / 64, 1, np.zeros(1, bool))
    start = np.diag([1e-2] * 4 + [rms**2])
    return plant, Noise(np.array([level, 0.2]), np.array([0.1, 0.2]), start)


LATE = np.array([[True, True]] * 5 + [[True, False]] * 3)


@pytest.mark.parametrize("missing", [None, LATE])
@pytest.mark.parametrize("with_laws", [False, True])
def test_systems_side_by_side_have_the_gains_that_each_has_alone(with_laws, missing):
    systems = [near(400.0, 0.3, 0.5), near(450.0, 0.3, 0.4), near(400.0, 0.1, 0.5)]
    laws = EquivalentLinear(np.full((5, 5), -1e-3), np.full((2, 5), 0.1)) if with_laws else None
    gain, innovation = neighbouring_gains(systems, 20, laws, missing)
    first = 20 if missing is None else 20 - len(missing)
    for i, (plant, noise) in enumerate(systems):
        alone = gains(plant, noise, first, laws, missing)
        together = np.concatenate([alone.state, alone.held], axis=1)
        assert gain[..., i] == pytest.approx(together, rel=1e-9, abs=1e-12)
        assert innovation[..., i] == pytest.approx(alone.innovation, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("missing", [None, LATE])
def test_blows_leave_their_states_less_certain_as_they_do_alone(missing):
    tall = np.outer(np.arange(1.0, 6.0), np.arange(1.0, 6.0))
    kicks = {12: 1e-3 * tall, 4: 1e-2 * tall}
    systems = [
        (p, replace(n, kicks=kicks)) for p, n in (near(400.0, 0.3, 0.5), near(450.0, 0.3, 0.4))
    ]
    for i, (plant, noise) in enumerate(systems):
        alone = gains(plant, noise, missing=missing)
        count = len(alone.state) - 1
        assert count > 20
        gain, innovation = neighbouring_gains(systems, count, None, missing)
        together = np.concatenate([alone.state, alone.held], axis=1)
        np.testing.assert_allclose(gain[..., i], together, atol=2e-3 * np.max(np.abs(together)))
        np.testing.assert_allclose(innovation[..., i], alone.innovation, rtol=2e-3)


def test_one_without_a_stationary_filter_is_said():
    plant, noise = near(400.0, 0.3, 0.5)
    blind = replace(plant.system, C=0 * plant.system.C)
    lost = replace(plant, whole=1.1 * plant.whole, system=blind)
    with pytest.raises(NoLikelihoodError, match="no stationary solution"):
        neighbouring_gains([(plant, noise), (lost, noise)], 20, None)
