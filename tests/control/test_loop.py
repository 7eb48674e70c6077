import control
import numpy as np
import pytest
from absorber_support import linear_run

from twin.control.loop import (
    closed_loop,
    sampled,
    spectral_radius,
    stability_margin,
    steady_vibration,
)
from twin.control.lqg import lqg
from twin.control.weights import Weights


@pytest.mark.parametrize("delay", [0, 1, 2])
def test_the_slowest_decay_is_the_spectral_radius(believed, controller, delay):
    loop = closed_loop(controller, believed, delay)
    state = np.linalg.matrix_power(loop, 600) @ np.random.default_rng(0).normal(size=len(loop))
    growth = [np.linalg.norm(state)]
    for _ in range(200):
        state = loop @ state
        growth.append(np.linalg.norm(state))
    rate = np.polyfit(np.arange(201), np.log(growth), 1)[0]
    assert np.exp(rate) == pytest.approx(spectral_radius(controller, believed, delay), abs=2e-3)


@pytest.mark.parametrize("delay", [0, 1, 2])
def test_the_loop_is_the_one_scipy_simulates(believed, controller, delay):
    """A force that ends leaves a state; from there on both decay alike."""
    inner, samples = 8, 120
    force = np.zeros(samples * inner + 1)
    force[: 20 * inner] = np.random.default_rng(3).normal(size=20 * inner)
    quick = lqg(believed, torque_limit=1e9, ramp_s=0.0)
    motion, torque, _ = linear_run(believed, quick, force, inner, delay)
    # the plant's state and the queue are not seen: predict with the loop's own polynomial
    polynomial = np.poly(np.linalg.eigvals(closed_loop(quick, believed, delay)))
    order = len(polynomial) - 1
    after = torque[21 + delay :]
    residual = np.convolve(after, polynomial.real)[order : len(after)]
    assert np.abs(residual).max() < 1e-7 * np.abs(after).max()
    assert np.abs(motion[-1]).max() > 0


@pytest.mark.parametrize("delay", [1, 2])
def test_the_margin_is_the_disk_margin_of_the_sensitivity(believed, controller, delay):
    p, c = sampled(believed, controller.dt, delay), controller
    plant = control.ss(p.A, p.B[:, None], p.C, np.zeros((len(p.C), 1)), c.dt)
    own = c.A + np.outer(c.B_u, c.C)
    fed = c.B_y + np.outer(c.B_u, c.D_y)
    regulator = control.ss(own, fed, c.C[None], c.D_y[None], c.dt)
    omega = np.linspace(1e-3, np.pi / c.dt, 40000)
    margin = control.disk_margins(-regulator * plant, omega, skew=1.0)[0]
    assert stability_margin(c, believed, delay) == pytest.approx(float(margin), rel=2e-3)


def test_an_unstable_loop_has_no_margin(believed):
    eager = lqg(believed, weights=Weights(torque=1e-7), delay=0.0)
    assert spectral_radius(eager, believed, 3) > 1
    assert stability_margin(eager, believed, 3) == 0.0


@pytest.mark.parametrize("delay", [0, 1, 2])
def test_steady_vibration_is_what_a_long_simulation_ends_in(plant, delay):
    model = plant.linear()
    controller = lqg(model, torque_limit=1e9, ramp_s=0.0, delay=delay + 0.5)
    inner, samples, frequency = 64, 32 * 40, 2.0
    time = np.arange(samples * inner + 1) / (32 * inner)
    force = np.sin(2 * np.pi * frequency * time)
    motion, torque, _ = linear_run(model, controller, force, inner, delay)
    found = steady_vibration(controller, model, np.array([frequency]), delay)
    tail = np.exp(-2j * np.pi * frequency * np.arange(samples) / 32)[-320:] / 160
    at_samples = motion[::inner][-320:]
    assert 1j * tail @ at_samples[:, :2] == pytest.approx(found.displacement[0], rel=0.01)
    assert 1j * tail @ at_samples[:, 2] == pytest.approx(found.angle[0], rel=0.01)
    assert 1j * tail @ torque[-320:] == pytest.approx(found.torque[0], rel=0.01)


def test_without_controller_the_vibration_is_that_of_the_equation_of_motion(plant):
    model = plant.linear()
    s, omega = model.structure, 2 * np.pi * 3.0
    x = np.linalg.solve(s.K + 1j * omega * s.R - omega**2 * s.M, model.influence())
    found = steady_vibration(None, model, np.array([3.0]))
    ground = x[s.coordinates.index("ground")] if "ground" in s.coordinates else 0
    expected = [x[s.coordinates.index(floor)] - ground for floor in ("floor1", "floor2")]
    assert found.displacement[0] == pytest.approx(np.array(expected))
