"""Modes above half the sampling rate, beside sums over fine samples and a recursion in steps."""

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander
from scipy.linalg import expm

from twin.estimation.low_pass import MOMENTS, LowPass, in_moments, twice, weights
from twin.estimation.ringing import Ringing
from twin.estimation.simulated import filtered

RATE_HZ, STEPS, SAMPLES = 100.0, 24, 256
STEP_S = 1 / RATE_HZ
FAST_HZ, RATIO, STEPPED = 72.0, 0.01, 0.7
OMEGA = 2 * np.pi * FAST_HZ
TWICE = in_moments(twice, LowPass(1.0), STEPS)
SEEN = np.array([[[3.0 * OMEGA**2], [0.0]], [[0.0], [OMEGA]], [[1.0], [0.0]]])


def mode(rate):
    """A mode as x' = A x + B f, and how two outputs see it less what the force does at once."""
    A = np.array([[0.0, 1.0], [-(OMEGA**2), -rate]])
    return (
        A,
        np.array([0.0, 1.0]),
        SEEN[0] @ [[1.0, 0.0]] + SEEN[1] @ [[0.0, 1.0]] + SEEN[2] @ A[1:],
    )


def knocks():
    """A force of one law that jumps within samples, over their parts, and its weighed sums."""
    rng = np.random.default_rng(3)
    weighed = weights(LowPass(1.0), STEPS)
    forces = np.zeros((SAMPLES * STEPS + weighed.shape[1], 1))
    for begin in rng.integers(900, SAMPLES * STEPS - 1200, 12):
        forces[begin : begin + rng.integers(9, 270), 0] += rng.normal()
    by_moments = in_moments(weights, LowPass(1.0), STEPS)
    more, _ = filtered(forces, np.empty((len(forces), 1, 0)), by_moments, STEPS, SAMPLES)
    return forces, more, weighed


def through_the_filter(forces, weighed):
    """The outputs of the mode, driven by the force in its parts, behind the filter."""
    A, B, C = mode(2 * RATIO * OMEGA)
    h = STEP_S / STEPS
    step = expm(np.block([[A, B[:, None]], [np.zeros((1, 3))]]) * h)
    x, seen = np.zeros(2), []
    for f in forces[:, 0]:
        moved = step[:2, :2] @ x + step[:2, 2] * f
        seen.append(C @ (x + moved) / 2)
        x = moved
    out = np.zeros((SAMPLES, 2))
    for k in range(SAMPLES):
        first = k * STEPS - weighed.shape[1] // STEPS // 2 * STEPS
        taps = np.arange(max(first, 0), first + weighed.shape[1])
        out[k] = weighed[0, taps - first] @ np.array(seen)[taps]
    return out


def in_steps(more):
    """The outputs of the mode, strongly damped, driven by polynomials in steps of a sample."""
    A, B, C = mode(2 * STEPPED * OMEGA)
    over = expm(A * STEP_S)
    t, share = leggauss(20)
    after = np.array([expm(A * STEP_S * (1 - x) / 2) @ B for x in t])
    entry = STEP_S / 2 * (share * legvander(t, MOMENTS - 1).T) @ after
    x, out = np.zeros(2), []
    for _, *moments in more:
        out.append(C @ x)
        x = over @ x + moments @ entry
    return np.array(out)


def fast(entry):
    """The mode, driven by laws through their entry, (1, laws)."""
    return Ringing(
        np.array([OMEGA**2]), np.array([2 * RATIO * OMEGA]), np.array([2 * STEPPED * OMEGA]),
        entry, SEEN,
    )  # fmt: skip


def test_a_fast_mode_is_seen_as_it_rings_behind_the_filter_not_as_it_is_stepped():
    forces, more, weighed = knocks()
    rings = fast(np.array([[1.0]]))
    beyond = rings.beyond(forces[:, :, None], more[:, :, None], TWICE, STEPS, STEP_S)[:, :, 0]
    true, stepped = through_the_filter(forces, weighed), in_steps(more)
    size = np.sqrt(np.mean(true**2, axis=0))
    before = np.sqrt(np.mean((stepped - true) ** 2, axis=0)) / size
    after = np.sqrt(np.mean((stepped + beyond - true) ** 2, axis=0)) / size
    assert np.all(before > 0.2)
    assert np.all(after < 0.01)


def test_laws_at_one_port_ring_as_one_force_that_is_their_sum():
    forces, more, _ = knocks()
    one, none = fast(np.array([[1.0]])), np.zeros_like
    both = fast(np.array([[1.0, 1.0, 0.5]]))
    shares = np.array([0.7, 0.3])
    split = np.hstack([forces * shares, none(forces)])
    sums = np.hstack([np.hstack([column * shares, none(column)]) for column in more.T[:, :, None]])
    whole = one.beyond(forces[:, :, None], more[:, :, None], TWICE, STEPS, STEP_S)
    found = both.beyond(split[:, :, None], sums[:, :, None], TWICE, STEPS, STEP_S)
    np.testing.assert_allclose(found, whole, atol=1e-12 * np.abs(whole).max())
