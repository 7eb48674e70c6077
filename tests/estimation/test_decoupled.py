"""Coordinates in which modes do not move one another."""

import numpy as np
import pytest

from twin.estimation.decoupled import decoupled

RNG = np.random.default_rng(5)


def oscillators(squares, rate):
    n = len(squares)
    lower = [-np.diag(squares), -rate]
    return np.block([[np.zeros((n, n)), np.eye(n)], lower])


def chain():
    """Three masses that dashpots couple, and a slow decaying state that drives them."""
    rate = 0.3 * np.eye(3) + 2.0 * np.ones((3, 3))
    A = np.zeros((7, 7))
    A[:6, :6] = oscillators([100.0, 900.0, 5e4], rate)
    A[3:6, 6], A[6, 6] = 1.0, -4.0
    return A


def test_a_state_is_moved_by_itself_and_its_neighbour_alone():
    A = chain()
    found = decoupled(A)
    turned = found.back @ A @ found.to
    far = np.ones_like(A, bool)
    for i, (low, high) in enumerate(found.near):
        assert high - low <= 2
        far[i, low:high] = False
    assert np.max(np.abs(turned[far])) < 1e-10 * np.max(np.abs(turned))
    assert sum(high - low == 1 for low, high in found.near) == 1, "one state decays by itself"


@pytest.mark.parametrize("shape", [(7, 7 + 4), (7, 7 + 4, 3)])
def test_a_step_leads_where_it_led_in_the_states_themselves(shape):
    found, step = decoupled(chain()), RNG.standard_normal(shape)
    x, others = RNG.standard_normal(7), RNG.standard_normal(4)
    led = np.tensordot(np.moveaxis(step, 1, -1), np.concatenate([x, others]), 1)
    q = np.concatenate([found.back @ x, others])
    turned = np.tensordot(np.moveaxis(found.of_step(step), 1, -1), q, 1)
    assert np.tensordot(found.to, turned, 1) == pytest.approx(led, rel=1e-9, abs=1e-9)


def test_units_of_the_states_do_not_matter():
    scale = np.diag(10.0 ** RNG.uniform(-6, 6, 7))
    found = decoupled(np.linalg.inv(scale) @ chain() @ scale)
    assert np.max(found.near[:, 1] - found.near[:, 0]) == 2


def test_what_moves_freely_keeps_its_states():
    """A free body's displacement and rate have one eigenvector between them."""
    found = decoupled(oscillators([0.0, 400.0], np.zeros((2, 2))))
    assert np.array_equal(found.to, np.eye(4))
    assert np.array_equal(found.near, [[0, 4]] * 4)


def test_what_is_not_finite_keeps_its_states():
    assert np.array_equal(decoupled(np.full((2, 2), np.nan)).to, np.eye(2))
