"""What is unknown of the instants at which friction jumps, beside what its jump says."""

from dataclasses import replace

import numpy as np
import pytest
from estimation_support import FRICTION, RATE_HZ, SLIP, rubbing
from scipy.linalg import solve_discrete_lyapunov
from scipy.signal import firwin, resample_poly
from test_simulated import model, recorded, truth

from twin.estimation.blows import FARTHEST, Blows
from twin.estimation.instants import _neighbours, _strayed, _variances, blown
from twin.estimation.laws import addresses
from twin.estimation.likelihood import evaluate, gaussian
from twin.estimation.low_pass import LowPass
from twin.estimation.model import Trial
from twin.estimation.sensitivities import plants_of

FORCE, PART_S = 0.6, 1e-3
NUMBERS = np.array([[FORCE, 1e-9]])
SCALES = np.array([[5.0, 0.01, 0.2, 0.0]])


def beyond(rate, forces, size, returning, push_rate, law=FRICTION, numbers=NUMBERS):
    """Forces of two neighbours beyond those of a motion with this rate, (parts, 2)."""
    moved = np.column_stack([np.cumsum(rate) * PART_S, rate])
    push = np.array([[0.5 * PART_S * push_rate], [push_rate]])
    out = np.zeros((len(forces), 2))
    _neighbours(addresses((law,)), numbers, push, SCALES, PART_S, 1, forces[:, None], moved,
                np.array([[size]]), np.array([[returning]]), out)  # fmt: skip
    return out


def crossing(a, parts=400):
    """A rate that passes zero with the acceleration a, and friction's mean force in each part."""
    rate = a * PART_S * (np.arange(parts + 1) - parts / 2 - 0.37)
    began = np.clip(-rate[:-1] / (rate[1:] - rate[:-1]), 0.0, 1.0)
    return rate, np.sign(a) * FORCE * (1 - 2 * began)


@pytest.mark.parametrize("a", [0.2, 1.0, -3.0])
def test_a_jump_comes_earlier_or_later_by_the_deviation_over_the_acceleration(a):
    size, (rate, forces) = 0.01, crossing(a)
    off = beyond(rate, forces, size, 1.0, -1e-6)
    moment = 2 * FORCE * size / abs(a)
    found = np.sum(off, axis=0) * PART_S
    np.testing.assert_allclose(found, [moment, -moment], rtol=0.02)


def test_friction_that_holds_is_known_however_the_rate_would_deviate():
    parts = 400
    rate = np.zeros(parts + 1)
    forces = 0.5 * FORCE * np.sin(np.arange(parts) / 30)
    off = beyond(rate, forces, 1e-4, 1e-6, -1e-3)
    assert np.max(np.abs(off[40:])) < 1e-3 * FORCE


def test_what_a_hold_has_taken_of_a_deviation_is_not_there_when_it_slides_again():
    slides = PART_S * np.arange(1, 202)
    rate = np.concatenate([np.zeros(200), slides])
    forces = np.append(np.linspace(0, FORCE, 200), np.full(200, FORCE))
    gone = beyond(rate, forces, 0.01, 0.0, -1e-3)
    assert np.max(np.abs(gone[40:])) < 1e-4 * FORCE
    back = beyond(rate, forces, 0.01, 2 * PART_S, -1e-3)
    assert np.max(np.abs(back[200:])) > 0.5 * FORCE


def test_a_law_with_a_memory_does_not_jump_with_the_rate():
    rate, forces = crossing(1.0)
    assert np.all(beyond(rate, forces, 0.01, 1.0, -1e-3, SLIP) == 0.0)


def test_what_parts_of_a_sample_resolve_does_not_jump():
    rate, _ = crossing(1.0)
    middle = 0.5 * (rate[1:] + rate[:-1])
    for width, jumps in [(0.2, 0), (1e-5, 2)]:
        forces = FORCE * np.tanh(middle / width)
        off = beyond(rate, forces, 0.01, 1.0, -3e-4, numbers=np.array([[FORCE, width]]))
        assert np.count_nonzero(np.max(np.abs(off), axis=0) > 0.1 * FORCE) == jumps


def test_deviations_stray_as_far_as_their_noise_adds_up():
    A, Q = np.array([[0.9, 0.2], [-0.1, 0.8]]), np.array([[0.5, 0.1], [0.1, 0.3]])
    np.testing.assert_allclose(_strayed(A, Q, 10_000), solve_discrete_lyapunov(A, Q), rtol=1e-12)
    powers = [np.linalg.matrix_power(A, k) for k in range(8)]
    np.testing.assert_allclose(_strayed(A, Q, 8), sum(p @ Q @ p.T for p in powers), rtol=1e-12)
    drifting = _strayed(np.eye(1), np.eye(1), 64)
    assert drifting == 64.0


def test_readings_near_a_jump_are_not_as_certain_as_others():
    whole, noise = recorded(4.0, 0.1), 0.1
    cut = Trial(*(part[100:-50] for part in (whole.u, whole.between, whole.y)), whole.step_s)
    of = replace(model(LowPass(1.0)), trials=(cut,))
    z = truth(of)
    z[[u.name for u in of.unknowns].index("input noise 0")] += np.log(noise / 2e-3) / 0.5
    found = evaluate(of, z, derivatives=False)
    run, trial = found.runs[0], found.trials[0]
    without = replace(run, averages=replace(run.averages, blur=None))
    here, apart = (gaussian(r, trial) for r in (run, without))
    assert here.value > apart.value + 500
    tails = [np.mean(part.white[:, 1] ** 4) for part in (here, apart)]
    assert tails[0] < 0.25 * tails[1]


def test_after_a_blow_deviations_are_larger_until_they_have_decayed():
    A, Q = np.array([[0.9, 0.2], [-0.1, 0.8]]), np.array([[0.5, 0.1], [0.1, 0.3]])
    rows, moved = np.array([[1.0, 0.0], [0.3, -1.0]]), np.array([4.0, -2.0])
    kick = {7: np.outer(moved, moved)}
    found = _variances(rows, Q, A, kick, 60)
    still = np.einsum("ln,nk,lk->l", rows, Q, rows)
    np.testing.assert_allclose(found[:6], np.tile(still, (6, 1)), rtol=1e-12)
    for k in (6, 9, 15):  # the sample in which it happens is uncertain as a whole
        there = np.linalg.matrix_power(A, k - 6) @ moved
        np.testing.assert_allclose(found[k], still + (rows @ there) ** 2, rtol=1e-12)
    np.testing.assert_allclose(found[-1], still, rtol=2e-3)


def struck(peak=60.0, noise=0.02):
    """Two masses with dry friction between them, struck; force and response through one filter."""
    fine, samples = 64, 600
    time = np.arange(samples * fine) / fine
    phase = (time - 40.37) / 1.1
    u = np.where((phase > 0) & (phase < 1), peak * np.sin(np.pi * phase), 0.0)
    window = firwin(32 * fine + 1, 1 / fine, window=("kaiser", 10.5))
    both = np.column_stack([u, rubbing(u, fine, FORCE)])
    seen = resample_poly(both, 1, fine, axis=0, window=window)
    rng = np.random.default_rng(5)
    seen[:, 1:] += noise * rng.standard_normal((samples, 2))
    lines = np.fft.irfft(np.fft.rfft(seen[:, 0]) / np.sinc(np.fft.rfftfreq(samples)) ** 2)
    y = seen[:, 1:].copy()
    y[-20:] = np.nan
    return Trial(seen[:, :1], lines[:, None], y, 1 / RATE_HZ, np.array([True]))


def test_friction_holds_until_a_blow_and_not_until_its_ringing():
    plain = struck()
    told = replace(plain, blows=Blows(plain.u, LowPass(1.0)))
    found = []
    for trial in (plain, told):
        of = replace(model(LowPass(1.0)), trials=(trial,))
        z = truth(of)
        z[[u.name for u in of.unknowns].index("output noise 0")] = np.log(0.02 / 0.05) / 0.5
        here = evaluate(of, z, derivatives=False)
        found.append((here.log_likelihood, gaussian(here.runs[0], trial).white[:-20]))
    (rung, _), (blown, white) = found
    assert blown > rung + 500
    assert np.max(np.abs(white)) < 6.0


def test_where_a_filter_shows_nothing_of_a_blow_any_more_readings_are_certain():
    plain = struck()
    told = replace(plain, blows=Blows(plain.u, LowPass(1.0)))
    of = replace(model(LowPass(1.0)), trials=(told,))
    here = of.assemble(truth(of))
    (plant,) = plants_of(here, of)
    _, seen = blown(here, 0, plant)
    (onset,) = told.blows.onsets(plant.steps)
    assert np.max(seen[int(onset) : int(onset) + 2]) > 0.02**2  # what its noise is
    assert not np.any(seen[int(onset) + FARTHEST + 1 :])
