"""The compiled filter with laws: against the linear one, an integration, and the array laws."""

import numba
import numpy as np
import pytest
from diagnosis_support import K1, ONE, RATE, TWO, error, motion, rng, rough, tones

from twin import mechanisms
from twin.diagnosis.compiled import MOST_NUMBERS, numbers_of
from twin.diagnosis.filtering import Gain, gain, linear, with_laws
from twin.diagnosis.plant import build, sampled
from twin.mechanisms.mechanism import Law

ALL = mechanisms.vocabulary()
LAWS = [c for c in ALL.values() if issubclass(c, Law)]
INPUTS, OUTPUTS = ("force_floor1", "force_floor2"), ("acc_floor1", "acc_floor2", "disp_floor2")
NOISE = (np.full(2, 0.02), np.array([0.05, 0.05, 1e-4]), np.diag([0.2, 0.1]))
FREE = np.full((1, 3), np.inf)


def run(laws, u, y, steps=1, rate=RATE, gains=None, start=None, limits=FREE, memory=None,
        begin_s=0.0):  # fmt: skip
    """Innovations, states and memories of variants that differ in their laws."""
    plants = [sampled(build(TWO, own, INPUTS, OUTPUTS), 1 / (rate * steps)) for own in laws]
    n = len(plants[0].A)
    if gains is None:
        gains = Gain(np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, n)), np.eye(3))
    start = np.zeros(n) if start is None else start
    limits = np.repeat(limits, len(laws), axis=0)
    return with_laws(
        plants, gains, laws, u[None], u[None], y[None], start, limits, steps, 1 / rate,
        memory, begin_s,
    )  # fmt: skip


def filled(cls):
    """A law of a class with values of every size at once."""
    draw = rng(7)
    law = cls("storey1" if cls.on != "motion" else "floor1")
    return law.with_values({name: float(draw.uniform(0.5, 2.0)) for name in law.parameters})


@pytest.mark.parametrize("cls", LAWS, ids=[c.name for c in LAWS])
def test_a_compiled_law_is_the_array_law(cls):
    law, draw = filled(cls), rng(11)
    assert len(law.numbers) <= MOST_NUMBERS
    d, v, z, t = draw.standard_normal((4, 200)) * np.array([[2.0], [3.0], [1.0], [5.0]])
    one = numba.njit(cls.law)
    found = [one(*row, *law.numbers) for row in np.column_stack([d, v, z, t])]
    np.testing.assert_allclose(found, law.force(d, v, z, t), rtol=1e-13, atol=1e-13)
    assert np.ptp(found) > 0.1, "the test shows something"
    if cls.flow is not None:
        step = numba.njit(cls.flow)
        after = d + 0.1 * draw.standard_normal(200)
        found = [step(*row, *law.numbers) for row in np.column_stack([z, d, after])]
        np.testing.assert_allclose(found, law.remember(z, d, after), rtol=1e-13, atol=1e-13)


def test_numbers_of_laws_stand_in_the_order_of_their_fields():
    bumper, cubic = ALL["bumper"]("storey1", 5.0, -0.1), ALL["cubic_stiffness"]("storey2", 7.0)
    found = numbers_of([(bumper, cubic), (bumper.scaled(2.0), cubic)])
    assert found.shape == (2, 2, MOST_NUMBERS)
    np.testing.assert_array_equal(found[1, :, :2], [[10.0, -0.1], [7.0, 0.0]])
    assert not found[:, :, 2:].any()


def test_without_laws_it_is_the_linear_filter():
    u = np.column_stack([rough(300, 1), rough(300, 2)])
    y, start = rng(4).standard_normal((300, 3)), np.array([1e-3, -2e-3, 0.05, 0.1])
    plant = sampled(build(TWO, (), INPUTS, OUTPUTS), 1 / RATE)
    gains = gain(plant, *NOISE)
    e, x, _ = run([()], u, y, gains=gains, start=start)
    wanted = linear(plant, gains, u, u, y, start)
    assert error(e[0], wanted.innovations) < 1e-11
    assert error(x[0], wanted.states) < 1e-11


def test_a_sample_in_pieces_is_the_same_sample():
    u = np.column_stack([rough(300, 1), rough(300, 2)])
    y = rng(4).standard_normal((300, 3))
    gains = gain(sampled(build(TWO, (), INPUTS, OUTPUTS), 1 / RATE), *NOISE)
    whole, pieces = (run([()], u, y, steps, gains=gains)[0] for steps in (1, 5))
    assert error(pieces, whole) < 1e-11


def shaken_cubic(samples=512):
    """A hard spring in the second storey: forces, outputs, states and the law."""
    law = ALL["cubic_stiffness"]("storey2", 4e6)
    u = np.column_stack([tones(samples, seed=3, scale=1.5), np.zeros(samples)])
    x, v, acc = motion(TWO, u, law=lambda d, rate: 4e6 * d**3, b=[-1, 1])
    return u, np.column_stack([acc, x[:, 1]]), np.hstack([x, v]), law


@pytest.mark.parametrize(("steps", "allowed"), [(2, 0.01), (8, 6e-4), (32, 4e-5)])
def test_a_cubic_spring_moves_as_integrated_the_better_the_shorter_the_steps(steps, allowed):
    u, y, states, law = shaken_cubic()
    e, x, _ = run([(law,)], u, y, steps)
    assert error(x[0], states) < allowed
    assert error(y - e[0], y) < 2 * allowed
    assert error(run([()], u, y)[1][0], states) > 0.2, "the test shows something"


def test_a_filter_that_listens_comes_back_to_the_motion_from_a_wrong_start():
    u, y, states, law = shaken_cubic()
    gains = gain(sampled(build(TWO, (law,), INPUTS, OUTPUTS), 1 / RATE), *NOISE)
    wrong = np.array([5e-3, -5e-3, 0.1, 0.1])
    listening = run([(law,)], u, y, 8, gains=gains, start=wrong)[1][0]
    deaf = run([(law,)], u, y, 8, start=wrong)[1][0]
    assert error(listening[-200:], states[-200:]) < 0.01
    assert error(deaf[:200], states[:200]) > 0.2


def test_variants_run_side_by_side_as_they_run_alone():
    u, y, _, law = shaken_cubic(200)
    other = law.scaled(0.5)
    together = run([(law,), (other,)], u, y, 2)
    for row, own in enumerate((law, other)):
        alone = run([(own,)], u, y, 2)
        for both, one in zip(together, alone, strict=True):
            np.testing.assert_array_equal(both[row], one[0])


def test_predictions_beyond_a_clipping_level_stay_there():
    u, y, _, law = shaken_cubic(200)
    limits = np.array([[np.inf, 0.3, np.inf]])
    free, clipped = (y - run([(law,)], u, y, 2, limits=lim)[0][0] for lim in (FREE, limits))
    assert np.abs(free[:, 1]).max() > 0.6
    np.testing.assert_allclose(clipped, np.clip(free, -limits[0], limits[0]), atol=1e-12)


def test_a_law_of_time_begins_at_the_time_of_the_first_sample():
    law = ALL["stiffness_drift"]("storey1", 0.05, 1300.0)
    u, y, _, _ = shaken_cubic(400)
    _, x, z = run([(law,)], u, y, 4)
    half = run([(law,)], u[200:], y[200:], 4, start=x[0, 200], memory=z[0, 200],
               begin_s=200 / RATE)[1][0]  # fmt: skip
    assert error(half, x[0, 200:]) < 1e-6
    reset = run([(law,)], u[200:], y[200:], 4, start=x[0, 200])[1][0]
    assert error(reset, x[0, 200:]) > 0.02, "the test shows something"


def test_a_slider_remembers_across_samples_and_pieces():
    law = ALL["hysteresis"]("storey1", 400.0, 5.0, 2.0, 400.0)
    u, y, _, _ = shaken_cubic(400)
    _, x, z = run([(law,)], u, y, 4)
    assert 3.5 < np.abs(z).max() <= 5.0
    half = run([(law,)], u[200:], y[200:], 4, start=x[0, 200], memory=z[0, 200])[1][0]
    assert error(half, x[0, 200:]) < 1e-6
    reset = run([(law,)], u[200:], y[200:], 4, start=x[0, 200])[1][0]
    assert error(reset, x[0, 200:]) > 0.02, "the test shows something"


def test_dry_friction_takes_the_free_decay_down_by_four_f_over_k_a_cycle():
    undamped = type(ONE)(ONE.M, [[0.0]], ONE.K, ("floor1",))
    force, period = 0.8, 2 * np.pi * np.sqrt(ONE.M[0, 0] / K1)
    rate = 40 / period
    law = ALL["coulomb_friction"]("storey1", force, 1e-5)
    plant = sampled(build(undamped, (law,), ("force_floor1",), ("disp_floor1",)), 1 / (rate * 32))
    deaf = Gain(np.zeros((2, 1)), np.zeros((2, 1)), np.zeros((2, 2)), np.eye(1))
    none = np.zeros((1, 161, 1))
    x = with_laws(
        [plant], deaf, [(law,)], none, none, none, np.array([0.03, 0.0]), np.full((1, 1), np.inf),
        32, 1 / rate,
    )[1][0]  # fmt: skip
    peaks = x[::40, 0]
    np.testing.assert_allclose(peaks, 0.03 - 4 * force / K1 * np.arange(5), rtol=5e-3)


def welded_and_slid(force, limit, fine=400):
    """Accelerations of the two floors with ideal dry friction in storey 2: held, or at its limit.

    Steps so small that a first-order one will do: the friction is what stops the drift within it,
    as far as it goes (Moreau 1988).
    """
    inverse, b = np.linalg.inv(TWO.M), np.array([-1.0, 1.0])
    x, v, out, dt = np.zeros(2), np.zeros(2), [], 1 / (RATE * fine)
    held = 0
    for k in range(len(force) - 1):
        for j in range(fine):
            u = force[k] + (force[k + 1] - force[k]) * j / fine
            free = inverse @ (np.array([0, u]) - TWO.R @ v - TWO.K @ x)
            needed = (b @ v / dt + b @ free) / (b @ inverse @ b)
            a = free - inverse @ b * np.clip(needed, -limit, limit)
            if j == 0:
                out.append(a)
            v = v + dt * a
            x = x + dt * v
            held += abs(needed) < limit
    return np.array(out), held / (fine * len(out))


def test_a_storey_sticks_in_the_filter_as_ideal_friction_lets_it():
    force = tones(600, seed=2, scale=0.6)
    true, held = welded_and_slid(force, 0.9)
    assert 0.3 < held < 0.9, "it sticks a good part of the time, and slides"
    u = np.column_stack([np.zeros(600), force])

    def felt(blur, steps):
        law = ALL["coulomb_friction"]("storey2", 0.9, blur)
        return -run([(law,)], u, np.zeros((600, 3)), steps)[0][0][:-1, :2]

    assert error(felt(1e-6, 16), true) < 0.01
    assert error(felt(1e-6, 4), true) < 0.06
    assert error(felt(1e-6, 16), true) < error(felt(1e-6, 4), true) < error(felt(1e-2, 4), true)


def test_friction_in_two_storeys_holds_both_at_once():
    force = tones(400, seed=2, scale=0.3)
    laws = tuple(ALL["coulomb_friction"](f"storey{i}", 50.0, 1e-6) for i in (1, 2))
    u = np.column_stack([np.zeros(400), force])
    e, x, z = run([laws], u, np.zeros((400, 3)), 4)
    assert np.abs(x).max() < 1e-6
    assert np.abs(e[0, :, :2]).max() < 1e-3 * np.abs(force).max()
    # each storey carries the push from above to the ground
    np.testing.assert_allclose(z[0], np.column_stack([force, force]), atol=1e-3)
