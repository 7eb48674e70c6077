from dataclasses import replace

import numpy as np
import pytest
from estimation_support import (
    BUMPER,
    CUBIC,
    FRICTION,
    NUMBERS,
    RATE_HZ,
    SLIDERS,
    SLIP,
    TwoMasses,
    shaken,
    two_masses,
)
from scipy.integrate import solve_ivp

from twin.estimation.kalman import Gains, gains, open_loop
from twin.estimation.laws import memory_along
from twin.estimation.likelihood import evaluate
from twin.estimation.model import Trial
from twin.estimation.passing import run
from twin.estimation.system import sampled

PORTS = ((1.0, 0.0),)


def passed(laws, ports, trial, steps, listening):
    model = TwoMasses((trial,), laws, ports, steps=steps)
    here = model.assemble(np.zeros(len(model.unknowns)))
    plant = sampled(here.systems[0], trial.step_s, steps, here.held)
    gain = gains(plant, here.noises[0])
    return run(here, trial, plant, gain if listening else open_loop(gain)), here


@pytest.mark.parametrize(("law", "steps", "error"), [
    (CUBIC, 2, 2e-2), (CUBIC, 8, 1.5e-3), (FRICTION, 4, 5e-3), (BUMPER, 4, 1e-2), (SLIP, 4, 1e-2),
    (SLIDERS, 4, 1e-2),
])  # fmt: skip
def test_laws_step_as_their_differential_equation(law, steps, error):
    samples = 150
    trial = shaken(samples, 21, (), ())
    found, here = passed((law,), PORTS, trial, steps, listening=False)
    system, times = here.systems[0], np.arange(samples) / RATE_HZ
    numbers = NUMBERS[law]

    def slope(t, state):
        x, z = state[:4], state[4:]
        u = np.interp(t, times, trial.u[:, 0])
        d, v = (system.drift @ x)[0], (system.rate @ x)[0]
        f = law.force(d, v, z.sum(), t, *numbers)
        flow = np.zeros(2)
        if law.flow is not None:
            k, limit = np.reshape(numbers, (2, law.parts))
            some = z[: law.parts]
            flow[: law.parts] = k * v * ((np.abs(some) < limit) | (some * v < 0))
        return np.append(system.A @ x + system.B[:, 0] * u + system.E[:, 0] * f, flow)

    expected = solve_ivp(slope, (0, times[-1]), np.zeros(6), t_eval=times, rtol=1e-8, atol=1e-10,
                         max_step=1 / RATE_HZ / 4).y[:4].T  # fmt: skip
    drift = expected @ system.drift[0]
    worst = np.sqrt(np.mean((found.x @ system.drift[0] - drift) ** 2) / np.mean(drift**2))
    assert worst < error


def test_what_friction_holds_rests():
    """With the rate of a step's middle it would change sign from step to step instead."""
    trial = shaken(600, 23, (), ())
    model = TwoMasses((trial,), (FRICTION,), PORTS, steps=4)
    here = model.assemble(np.zeros(len(model.unknowns)))
    here.numbers[0, :2] = 4.0, 1e-6
    plant = sampled(here.systems[0], trial.step_s, 4, here.held)
    found = run(here, trial, plant, open_loop(gains(plant, here.noises[0])))
    rate = found.x @ here.systems[0].rate[0]
    held = np.abs(found.f[:, 0]) < 3.9
    assert np.mean(held) > 0.2
    assert np.max(np.abs(rate[held])) < 1e-5


def held_by_a_light_mass(steps, yielding):
    """A mass on a spring and, by another, a light one that friction holds: how the first moves.

    And for which share of the samples friction holds the light one.
    """
    trial = shaken(600, 29, (), ())
    system = two_masses(400.0, ((0.0, 1.0),), process=False)
    M, K = np.diag([2.0, 1e-4]), np.array([[600.0, -200.0], [-200.0, 200.0]])
    A = np.zeros((4, 4))
    A[:2, 2:], A[2:, :2] = np.eye(2), -np.linalg.solve(M, K)
    A[2:, 2:] = -0.02 * np.sqrt(np.linalg.solve(M, np.diag(np.diag(K))))
    through = np.linalg.solve(M, np.eye(2))
    B, E = (np.vstack([np.zeros((2, 1)), side * through[:, [c]]]) for side, c in ((1, 0), (-1, 1)))
    system = replace(system, A=A, B=B, E=E, W=np.zeros((4, system.W.shape[1])))
    model = TwoMasses((trial,), (FRICTION,), ((0.0, 1.0),), steps=steps, yielding=yielding)
    here = replace(model.assemble(np.zeros(len(model.unknowns))), systems=(system,))
    here.numbers[0, :2] = 0.4, 1e-5
    plant = sampled(system, trial.step_s, steps, here.held)
    nothing = Gains(*(np.zeros((1, rows, 2)) for rows in (4, system.W.shape[1], 2)), np.eye(4))
    passed = run(here, trial, plant, nothing)
    light = passed.x[:, 1]
    return passed.x[:, 0], np.mean(np.abs(np.diff(light)) < 1e-3 * np.std(light))


def test_where_a_mode_is_too_fast_for_a_part_friction_holds_the_displacement():
    true, resting = held_by_a_light_mass(512, 0.0)
    assert resting > 0.05

    def error(steps, yielding):
        moved, _ = held_by_a_light_mass(steps, yielding)
        return np.sqrt(np.mean((moved - true) ** 2) / np.mean(true**2))

    assert error(4, 0.0) > 0.2
    assert error(4, 1.0) < 0.01
    assert error(16, 1.0) < 1e-4


def test_where_every_mode_is_in_step_the_rate_at_the_end_is_the_better_one():
    trial = shaken(600, 29, (), ())

    def moved(steps, yielding):
        model = TwoMasses((trial,), (FRICTION,), ((-1.0, 1.0),), steps=steps, yielding=yielding)
        here = model.assemble(np.zeros(len(model.unknowns)))
        here.numbers[0, :2] = 2.0, 1e-6
        plant = sampled(here.systems[0], trial.step_s, steps, here.held)
        return run(here, trial, plant, open_loop(gains(plant, here.noises[0]))).x[:, :2]

    true = moved(512, 0.0)
    by_rate, by_displacement = (np.linalg.norm(moved(4, y) - true) for y in (0.0, 1.0))
    assert by_rate < 0.2 * by_displacement < 2e-3 * np.linalg.norm(true)


@pytest.mark.parametrize("listening", [False, True])
@pytest.mark.parametrize("law", [FRICTION, BUMPER])
def test_finer_steps_converge_in_open_and_in_closed_loop(law, listening):
    trial = shaken(400, 22, (law,), PORTS)
    runs = [passed((law,), PORTS, trial, steps, listening)[0].e for steps in (2, 8, 32, 128)]
    size = np.sqrt(np.mean(runs[-1] ** 2)) if listening else np.sqrt(np.mean(trial.y**2))
    errors = [np.sqrt(np.mean((e - runs[-1]) ** 2)) / size for e in runs[:-1]]
    assert errors[0] > 3 * errors[1] > 9 * errors[2]
    assert errors[2] < 5e-3


def test_two_laws_at_one_port_are_solved_together():
    trial = shaken(200, 23, (), ())
    together, here = passed((CUBIC, FRICTION), PORTS * 2, trial, 16, listening=False)
    fine, _ = passed((CUBIC, FRICTION), PORTS * 2, trial, 128, listening=False)
    assert together.x == pytest.approx(fine.x, abs=2e-3 * np.max(np.abs(fine.x)))
    assert together.f[:, 0] == pytest.approx(4e5 * (together.x @ here.systems[0].drift[0]) ** 3)


def test_a_law_of_no_strength_changes_nothing():
    trial = shaken(150, 24, (), ())
    model = TwoMasses((trial,), (CUBIC,), PORTS)
    z = np.zeros(4)
    z[1] = -150.0  # the law's number is e^-45 of what it was
    without = evaluate(TwoMasses((trial,)), np.zeros(3), derivatives=False)
    steps = evaluate(model, z, derivatives=False)
    assert steps.log_likelihood == pytest.approx(without.log_likelihood, abs=1e-4)


def test_missing_samples_pass_without_correction():
    trial = shaken(80, 25, (), ())
    y = trial.y.copy()
    y[30:40] = np.nan
    hidden, _ = passed((), (), Trial(trial.u, trial.between, y, trial.step_s), 1, listening=True)
    assert np.all(hidden.e[30:40] == 0)
    A = hidden.sampled
    for k in range(30, 39):
        onward = A.A @ hidden.x[k] + A.B0 @ trial.u[k] + A.B1 @ trial.u[k + 1]
        assert hidden.x[k + 1] == pytest.approx(onward, abs=1e-12)


def test_memory_along_a_displacement_is_that_of_the_flow():
    drift = np.array([0.0, 0.001, 0.004, 0.002, -0.004])
    memory = memory_along(SLIP, np.array(NUMBERS[SLIP]), drift)
    assert memory == pytest.approx([0.0, 0.3, 0.8, 0.2, -0.8])
    apart = memory_along(SLIDERS, np.array(NUMBERS[SLIDERS]), drift)
    assert apart == pytest.approx([0.0, 0.3, 0.6, 0.0, -0.6])
    assert memory_along(CUBIC, np.array([1.0]), drift) == pytest.approx(np.zeros(5))


def test_a_law_much_stiffer_than_the_structure_does_not_run_away():
    trial = shaken(150, 26, (), ())
    model = TwoMasses((trial,), (CUBIC,), PORTS, steps=4)
    z = np.zeros(4)
    z[1] = 30.0  # e^9 times as stiff
    here = model.assemble(z)
    plant = sampled(here.systems[0], trial.step_s, 4, here.held)
    free = run(here, trial, plant, open_loop(gains(plant, here.noises[0])))
    soft = passed((CUBIC,), PORTS, trial, 4, listening=False)[0]
    drift = here.systems[0].drift[0]
    assert np.max(np.abs(free.x @ drift)) < np.max(np.abs(soft.x @ drift))
