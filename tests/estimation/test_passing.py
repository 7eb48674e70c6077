"""Where a recording begins a force that jumps is unknown by as much as it is."""

from dataclasses import replace

import numpy as np
import pytest
from estimation_support import CUBIC, FRICTION, TwoMasses, shaken
from scipy.stats import norm

from twin.arrays import frozen
from twin.estimation.averages import averages_at
from twin.estimation.kalman import gains, start_covariances, stationary
from twin.estimation.law_averages import LawAverages
from twin.estimation.passing import run
from twin.estimation.sensitivities import plants_of, slopes_of
from twin.estimation.stepping import predict
from twin.estimation.trust import doubt_of, trust_in
from twin.estimation.unknown_forces import _variance, unknown_forces

PORTS = ((1.0, 0.0),)


def passed(law):
    trial = shaken(300, 31, (law,), PORTS)
    model = TwoMasses((trial,), (law,), PORTS)
    here = model.assemble(np.zeros(len(model.unknowns)))
    plants = plants_of(here, model)
    equivalent = averages_at(model, here, plants, 0).equivalent
    gain = gains(plants[0], here.noises[0], equivalent=equivalent)
    return here, run(here, trial, plants[0], gain), equivalent, gain


def test_covariances_lead_from_the_first_to_the_stationary_one():
    here, result, equivalent, gain = passed(CUBIC)
    found = start_covariances(result.sampled, here.noises[0], gain, equivalent)
    assert found[0] == pytest.approx(here.noises[0].start)
    last = np.sqrt(np.diag(found[-1]))
    assert last == pytest.approx(np.sqrt(np.diag(gain.predicted)), rel=0.05)
    C = result.sampled.system.C + equivalent.C
    for k in (0, 3, len(found) - 1):  # what is left of an innovation's covariance is its noise
        rest = gain.innovation[k] - C @ found[k] @ C.T
        noise = gain.innovation[-1] - C @ gain.predicted @ C.T
        assert rest == pytest.approx(noise, rel=1e-6, abs=1e-9 * np.max(np.abs(noise)))


def test_loops_are_compiled_once_in_whatever_arrays_a_recording_is():
    """Each kind of array costs half a minute before the first result."""
    here, result, _, gain = passed(CUBIC)
    trial, plant = here.trials[0], result.sampled
    kinds = len(predict.signatures), len(stationary.signatures)
    still = {"u": frozen(trial.u), "between": frozen(trial.between), "y": frozen(trial.y)}
    columns = {name: np.asfortranarray(values) for name, values in still.items()}
    for arrays in (still, columns):
        again = run(here, replace(trial, **arrays), plant, gain)
        np.testing.assert_array_equal(again.e, result.e)
    other = replace(plant.system, C=np.asfortranarray(plant.system.C))
    gains(replace(plant, system=other), here.noises[0])
    assert (len(predict.signatures), len(stationary.signatures)) == kinds


def spread(here, result, gain):
    row = result.sampled.system.rate[0]
    return np.sqrt(row @ gain.predicted @ row), np.sqrt(row @ here.noises[0].start @ row)


def test_a_force_is_unknown_at_first_and_known_where_the_rate_keeps_its_sign():
    here, result, equivalent, gain = passed(FRICTION)
    still = np.zeros((1, result.x.shape[1]))
    unknown = unknown_forces(here, result, here.noises[0], equivalent, still)[:, 0]
    force, width = here.numbers[0, :2]
    settled, first = spread(here, result, gain)
    assert first > 100 * settled
    assert unknown[0] == pytest.approx(force, rel=0.01)  # of either sign, each as likely
    rate = np.abs(result.x @ result.sampled.system.rate[0])
    fast = rate[260:] > 4 * (settled + width)
    assert np.max(unknown[260:][fast]) < 0.01 * force


def test_what_is_uncertain_of_a_jump_is_its_binomial_variance():
    def jump(d, v):
        return 3.0 * np.sign(v)

    zeros = np.zeros(5)
    motion, wide = np.stack([zeros, np.arange(5.0)]), np.stack([zeros, zeros + 2.0])
    found = _variance(jump, motion, wide, zeros + 1e9, (0.0, 0.0))
    below = norm.cdf(-motion[1] / 2.0)
    assert found == pytest.approx(4 * 9.0 * below * (1 - below), abs=0.08 * 9.0)
    assert found[0] == pytest.approx(9.0)


def test_of_a_linear_force_the_variance_is_that_of_the_motion():
    def linear(d, v):
        return 2.0 * d + 0.5 * v

    motion, wide = np.ones((2, 3)), np.stack([np.full(3, 0.1), np.full(3, 0.2)])
    found = _variance(linear, motion, wide, np.ones(3), (-1.0, -0.5))
    inside = norm.expect(lambda x: x**2, lb=-3, ub=3, conditional=True)
    assert found == pytest.approx(inside * (2.0 * 0.1 + 0.5 * 0.2) ** 2, rel=0.02)


def test_what_holds_leaves_nothing_of_an_uncertain_rate():
    def held(d, v):
        return np.tanh(v / 1e-6)

    motion, wide = np.zeros((2, 1)), np.stack([np.zeros(1), np.full(1, 1e-3)])
    free = _variance(held, motion, wide, np.zeros(1), (-1e-9, 0.0))
    braked = _variance(held, motion, wide, np.zeros(1), (-1.0, 0.0))
    assert free == pytest.approx(1.0, rel=0.2)
    assert braked < 1e-6 * free


def test_slopes_that_go_on_longer_than_gains_take_to_settle_end_with_them():
    trial = shaken(200, 5, (), ())
    model = TwoMasses((trial,), (), ())
    z = np.zeros(len(model.unknowns))
    here = model.assemble(z)
    plants = plants_of(here, model)
    (d,) = slopes_of(model, z, here, plants, [LawAverages()], np.ones(len(z), bool))
    whole = gains(plants[0], here.noises[0])
    settled, early = len(d.innovation), 10
    assert len(whole.innovation) == settled > early
    short = replace(whole, innovation=whole.innovation[[*range(early - 1), -1]])
    expected = d.innovation[[*range(early - 1), -1]]
    np.testing.assert_array_equal(d.until(early), expected)
    np.testing.assert_array_equal(d.until(settled + 5), d.innovation)
    trust = trust_in(short, np.full((200, 2), 0.1))
    doubt = doubt_of(short, trust, d)
    np.testing.assert_allclose(doubt[:-1], doubt_of(whole, trust, d)[: early - 1])
    np.testing.assert_allclose(doubt[-1], doubt_of(whole, trust, d)[-1])
