"""What is uncertain while a stop is hit."""

from dataclasses import replace

import numpy as np
import pytest
from estimation_support import BUMPER, NUMBERS, RATE_HZ, TwoMasses, shaken, two_masses
from scipy.signal import cont2discrete

from twin.estimation.acting import while_acting
from twin.estimation.fit import fit
from twin.estimation.law_averages import LawAverages
from twin.estimation.likelihood import evaluate
from twin.estimation.low_pass import LowPass
from twin.estimation.model import Trial
from twin.estimation.system import sampled, transition

STOP = ((1.0, 0.0),)
STEP_S = 1 / RATE_HZ


def model(trial, **options):
    return TwoMasses((trial,), (BUMPER,), STOP, errors=True, **options)


def damped_stop(seed, samples=600, damping=2.0, fine=64, noise=(0.05, 0.02)):
    """The two masses at a stop that damps while it is hit, by an integration of its own."""
    rng = np.random.default_rng(seed)
    u = 4 * np.convolve(rng.normal(size=samples + 8), np.ones(9) / 3, "valid")
    system = two_masses(ports=STOP, process=False)
    step, push, _ = transition(system.A, np.column_stack([system.B, system.E]), STEP_S / fine, 0)
    k, gap = NUMBERS[BUMPER]
    x, y = np.zeros(4), np.zeros((samples, 2))
    for i in range(samples):
        for part in range(fine):
            end = u[min(i + 1, samples - 1)]
            now = u[i] + (end - u[i]) * (part + 0.5) / fine
            f = max(k * (x[0] - gap) + damping * x[2], 0.0) if x[0] > gap else 0.0
            if part == 0:
                y[i] = system.C @ x + system.D[:, 0] * u[i] + system.F[:, 0] * f
            x = step @ x + push[:, 0] * now + push[:, 1] * f
    y += noise[0] * rng.normal(size=y.shape)
    u = u[:, None] + noise[1] * rng.normal(size=(samples, 1))
    return Trial(u, u, y, STEP_S)


def test_a_force_that_is_off_moves_the_state_as_one_that_is_held_over_the_sample():
    system = two_masses(ports=STOP)
    plant = sampled(system, STEP_S, 4, np.zeros(1, bool))
    forces = np.zeros((50, 1))
    forces[[10, 11, 30], 0] = 3.0, -2.0, 5.0
    found = while_acting(LawAverages(), plant, [0.2], forces)
    moved = cont2discrete((system.A, system.E, system.C, system.F), STEP_S)[1]
    # what begins or ends in a sample has acted in it
    within = {10: 3.0, 11: 3.0, 12: 2.0, 30: 5.0, 31: 5.0}
    assert sorted(found.kicks) == sorted(within)
    for sample, force in within.items():
        expected = (0.2 * force) ** 2 * moved @ moved.T
        np.testing.assert_allclose(found.kicks[sample], expected, rtol=1e-9)
    expected = (0.2 * forces) ** 2 * (system.F[:, 0] ** 2)
    np.testing.assert_allclose(found.blur, expected, rtol=1e-12)


@pytest.mark.parametrize("before", [0.1, 0.7])
def test_another_share_makes_as_uncertain_as_if_it_had_been_so_from_the_beginning(before):
    plant = sampled(two_masses(ports=STOP), STEP_S, 4, np.zeros(1, bool))
    forces = np.random.default_rng(1).normal(size=(40, 1))
    known, expected = (while_acting(LawAverages(), plant, [s], forces) for s in (before, 0.3))
    found = while_acting(known, plant, [0.3])
    np.testing.assert_allclose(found.blur, expected.blur, rtol=1e-9)
    for sample, kick in expected.kicks.items():
        np.testing.assert_allclose(found.kicks[sample], kick, rtol=1e-9)


@pytest.mark.parametrize("low_pass", [None, LowPass(0.9)], ids=["followed", "simulated"])
def test_the_slope_by_the_share_is_that_of_the_likelihood(low_pass):
    m = model(damped_stop(2), low_pass=low_pass)
    z = np.zeros(len(m.unknowns))
    here = evaluate(m, z)
    h, found = 1e-3, []
    for side in (1.0, -1.0):
        moved = z.copy()
        moved[-1] += side * h
        at = evaluate(m, moved, derivatives=False, averages=here.averages)
        found.append(at.log_likelihood)
    assert len(here.averages[0].kicks) > 20
    assert here.gradient[-1] == pytest.approx((found[0] - found[1]) / (2 * h), rel=0.02)
    assert here.information[-1, -1] > 1.0


def test_a_stop_that_damps_is_known_for_one_that_is_off_and_spoils_nothing_else():
    trial = damped_stop(3, noise=(0.01, 0.005))
    found = fit(model(trial))
    exact = fit(TwoMasses((trial,), (BUMPER,), STOP))
    assert found.log_evidence > exact.log_evidence + 300
    assert 0.05 < found.values["error"] < 0.5
    assert found.values["input noise 0"] < 0.1 * exact.values["input noise 0"]
    off = abs(found.values["stiffness"] - 400.0) / found.deviations["stiffness"]
    assert off < 4


def test_a_stop_that_is_elastic_is_not_off():
    trial = shaken(600, 5, (BUMPER,), STOP)
    found = fit(model(trial))
    assert found.values["error"] < 0.05
    assert found.values["law 0 number 1"] == pytest.approx(NUMBERS[BUMPER][1], rel=0.05)


def test_where_nothing_is_hit_the_share_is_what_it_was_beforehand():
    far = shaken(200, 6)
    m = model(far)
    z = np.zeros(len(m.unknowns))
    z[2] = 20.0  # of the gap
    here = evaluate(m, z)
    assert not here.averages[0].kicks
    assert here.gradient[-1] == 0.0
    assert here.information[-1, -1] == 0.0


def test_what_is_uncertain_beyond_the_end_of_a_part_is_left_out():
    whole = model(damped_stop(4))
    z = np.zeros(len(whole.unknowns))
    near = evaluate(whole, z, derivatives=False).averages
    trial = whole.trials[0]
    part = replace(whole, trials=(Trial(*(a[:200] for a in (trial.u, trial.between, trial.y)),
                                        trial.step_s),))  # fmt: skip
    known, afresh = (evaluate(part, z, near=n) for n in (near, None))
    assert max(known.runs[0].averages.kicks) < 200
    assert known.log_likelihood == pytest.approx(afresh.log_likelihood, abs=0.5)
