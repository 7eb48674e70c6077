"""A sample at once does what its parts do in turn."""

import numpy as np
import pytest
from estimation_support import two_masses

from twin.estimation.system import sampled


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("steps", [1, 4])
def test_a_sample_at_once_moves_state_and_ports_as_its_parts_do_in_turn(steps, held):
    plant = sampled(two_masses(), 0.05, steps, np.array([held]))
    rng = np.random.default_rng(1)
    begin, u0, u1, n = (rng.normal(size=k) for k in (4, 1, 1, 2))
    forces = rng.normal(size=(steps, 1))
    rows = np.vstack([plant.system.drift, plant.system.rate])
    known = np.concatenate([begin, n, u0, u1])
    x, whole = begin, plant.lifted
    for part in range(steps):
        before, after = (u0 + (0 if held else j / steps) * (u1 - u0) for j in (part, part + 1))
        x = plant.A @ x + plant.B0 @ before + plant.B1 @ after
        x = x + plant.E @ forces[part] + plant.W @ n
        pushed = sum(whole.push[part - i] @ forces[i] for i in range(part + 1))
        np.testing.assert_allclose(whole.reach[part] @ known + pushed, rows @ x, atol=1e-12)
    over = whole.over @ np.concatenate([known, forces.ravel()])
    np.testing.assert_allclose(over, x, atol=1e-12)
