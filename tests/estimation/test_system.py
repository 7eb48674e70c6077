import numpy as np
import pytest
from estimation_support import two_masses
from scipy.integrate import solve_ivp
from scipy.linalg import solve_discrete_lyapunov

from twin.estimation.system import noise_integral, sampled


@pytest.mark.parametrize("steps", [1, 3])
@pytest.mark.parametrize("held", [False, True])
def test_a_sampled_system_steps_as_its_differential_equation(steps, held):
    system = two_masses()
    step = 0.05
    plant = sampled(system, step, steps, np.array([held]))
    rng = np.random.default_rng(1)
    x0, u0, u1, n = rng.normal(size=4), rng.normal(size=1), rng.normal(size=1), rng.normal(size=2)
    if held:
        u1 = u0
    f = rng.normal(size=1)

    def slope(t, x):
        u = u0 + t / step * (u1 - u0)
        return system.A @ x + system.B @ u + system.E @ f + system.W @ n

    expected = solve_ivp(slope, (0, step), x0, rtol=1e-11, atol=1e-13).y[:, -1]
    x = x0
    for part in range(steps):
        a = u0 + part / steps * (u1 - u0)
        b = u0 + (part + 1) / steps * (u1 - u0)
        x = plant.A @ x + plant.B0 @ a + plant.B1 @ b + plant.E @ f + plant.W @ n
    assert x == pytest.approx(expected, rel=1e-8)
    still = plant.whole @ x0 + plant.entry @ n
    inputs = x - still
    other = sampled(system, step, 1, np.array([held]))
    forced = other.B0 @ u0 + other.B1 @ u1 + other.E @ f
    assert inputs == pytest.approx(forced, abs=1e-10)


def test_the_noise_of_a_latent_force_leaves_its_stationary_covariance():
    system = two_masses(latent=(0.3, 5.0), process=False)
    plant = sampled(system, 0.05, 2, np.zeros(1, bool))
    P = solve_discrete_lyapunov(plant.whole, plant.Q)
    assert P[4, 4] == pytest.approx(0.3**2, rel=1e-9)
    # and it is that of the continuous equation
    assert pytest.approx(0, abs=1e-8) == system.A @ P + P @ system.A.T + system.G @ system.G.T


def test_noise_through_modes_that_decay_within_a_sample_leaves_a_covariance():
    # the integral of exp((a_i + a_j) s) g_i g_j, seen through a turn that couples all of them
    decay, entry, step_s = np.array([-0.3, -40.0, -9e3, -3e4]), np.array([1.0, -2, 30, 50]), 1 / 192
    sums = decay[:, None] + decay
    exact = np.outer(entry, entry) * np.expm1(sums * step_s) / sums
    turn, _ = np.linalg.qr(np.random.default_rng(1).standard_normal((4, 4)))
    found = turn.T @ noise_integral(turn * decay @ turn.T, (turn @ entry)[:, None], step_s) @ turn
    size = np.sqrt(np.diag(exact))
    assert np.abs((found - exact) / np.outer(size, size)).max() < 1e-6
    assert np.linalg.eigvalsh(found)[0] > -1e-12 * np.linalg.eigvalsh(found)[-1]
