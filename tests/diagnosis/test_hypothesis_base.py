"""Hypotheses: what every rig has, what a fit may change, and how sure one may be afterwards."""

from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_support import TWO, lumped, rng, tones

from twin import mechanisms
from twin.diagnosis.base import base_hypothesis, storey_values, storeys_of
from twin.diagnosis.evidence import WINDOW, probabilities, probability_over, windows
from twin.diagnosis.fitting import log_prior
from twin.diagnosis.plant import build

ALL = mechanisms.vocabulary()


def test_a_chain_s_springs_are_read_off_its_matrix():
    assert storeys_of(TWO) == ["storey1", "storey2"]
    values = storey_values(TWO, TWO.K)
    assert values["storey1"] == pytest.approx(700.0)
    assert values["storey2"] == pytest.approx(600.0)


def test_the_base_is_the_model_until_it_is_fitted():
    model = lumped().second_order()
    base = base_hypothesis(model)
    built = build(model, base.mechanisms, ("force_floor1",), ("acc_floor1",)).model
    for name in "MRK":
        np.testing.assert_array_equal(getattr(built, name), getattr(model, name))
    kinds = {(m.name, m.place) for m in base.base}
    assert {("stiffness", "storey2"), ("mass", "floor1"), ("damping", "floor2")} <= kinds
    assert len(kinds) == len(base.base)


def test_the_prior_is_the_tolerance_as_a_share_of_what_is_there():
    base = base_hypothesis(TWO, tolerance=0.01, damping_tolerance=0.2)
    told = {(m.name, m.place): t for m, t in zip(base.base, base.tolerance, strict=True)}
    assert told["stiffness", "storey1"] == pytest.approx(7.0)
    assert told["mass", "floor2"] == pytest.approx(0.012)
    assert told["damping", "storey2"] == pytest.approx(0.14)
    unknowns = base.unknowns()
    assert [u.prior_std for u in unknowns] == list(base.tolerance)
    one_off = np.zeros(len(unknowns))
    one_off[0] = base.tolerance[0]
    assert log_prior(unknowns, one_off) == pytest.approx(-0.5)


def test_a_parameter_that_is_found_has_no_prior_but_what_its_mechanism_knows():
    found = base_hypothesis(TWO).including(
        ALL["bumper"]("storey1", 2000.0, -0.004),
        ALL["hysteresis"]("storey2", 300.0, 0.5, 2.0, 300.0, 0.5, 600.0),
    )
    mine = {(u.index, u.name): u for u in found.unknowns()}
    first = len(found.base)
    stop, slip = mine[first, "stiffness"], mine[first + 1, "stiffness"]
    assert stop.log
    assert np.isinf(stop.prior_std)
    assert not mine[first, "gap"].log
    # from a thousandth of the storey's stiffness to all of it lies within two deviations
    for share in (1e-3, 1.0):
        pull = (np.log(share * 600) - slip.prior_mean) / slip.prior_std
        assert abs(pull) < 2
    replaced = mine[first + 1, "replaced"]
    assert (replaced.prior_mean, replaced.prior_std) == (300.0, 150.0)


def test_values_go_to_a_vector_and_come_back():
    hypothesis = base_hypothesis(TWO).including(
        ALL["bumper"]("storey1", 2000.0, -0.004), ALL["cubic_stiffness"]("storey2", -1e5)
    )
    unknowns = hypothesis.unknowns()
    vector = hypothesis.vector(unknowns)
    assert vector[-3] == pytest.approx(np.log(2000.0))
    np.testing.assert_array_equal(vector[-2:], [-0.004, -1e5])
    moved = vector + 0.1 * rng(1).standard_normal(len(vector))
    other = hypothesis.at(unknowns, moved)
    np.testing.assert_allclose(other.vector(unknowns), moved, rtol=1e-12)
    assert other.labels == hypothesis.labels == (
        ("bumper", "storey1"), ("cubic_stiffness", "storey2"))  # fmt: skip
    same = hypothesis.at(unknowns, vector)
    assert same.base == hypothesis.base
    assert same.found[0].stiffness == pytest.approx(2000.0)


def test_many_vectors_make_mechanisms_of_arrays():
    hypothesis = base_hypothesis(TWO).including(ALL["cubic_stiffness"]("storey2", -1e5))
    unknowns = hypothesis.unknowns()
    many = np.tile(hypothesis.vector(unknowns), (3, 1))
    many[:, -1] = [1.0, 2.0, 3.0]
    found = hypothesis.at(unknowns, many).found[0]
    np.testing.assert_array_equal(found.stiffness, [[1.0, 2.0, 3.0]])


def test_a_finding_takes_the_place_of_the_base_s_deviation():
    base = base_hypothesis(TWO)
    unknowns = base.unknowns()
    fitted = base.at(unknowns, np.arange(1.0, len(unknowns) + 1))
    found = fitted.including(ALL["stiffness"]("storey2", -50.0))
    left = {(m.name, m.place): m.values["change"] for m in found.base}
    before = {(m.name, m.place): m.values["change"] for m in fitted.base}
    assert left.pop(("stiffness", "storey2")) == 0.0
    assert before.pop(("stiffness", "storey2")) != 0.0
    assert left == before
    free = [found.mechanisms[u.index] for u in found.unknowns()]
    assert sum((m.name, m.place) == ("stiffness", "storey2") for m in free) == 1
    assert len(found.unknowns()) == len(unknowns)


def fitted_like(innovations, free=1):
    """What the evidence reads of a fit."""
    total = sum(len(e) for e in innovations)
    return SimpleNamespace(innovations=innovations, free=free, samples=total, log_prior=0.0)


def noise(seed, scale=1.0, samples=8 * WINDOW):
    return scale * rng(seed).standard_normal((samples, 2))


def test_windows_add_up_to_the_log_likelihood_but_for_what_is_cut_off():
    e = noise(1)
    found = windows(fitted_like([e, e[: WINDOW + 7]]))
    assert found.shape == (9,)
    S = e.T @ e / len(e)
    each = -0.5 * np.einsum("ki,ij,kj->k", e, np.linalg.inv(S), e) - 0.5 * np.log(np.linalg.det(S))
    assert found[:8].sum() == pytest.approx(each.sum(), rel=1e-9)


def test_probabilities_add_up_to_one_and_fall_with_the_fit():
    good = noise(1)
    fits = [fitted_like([good + noise(2, scale)]) for scale in (0.0, 0.04, 0.08)]
    found = probabilities(fits)
    assert sum(found) == pytest.approx(1.0)
    assert found[0] > found[1] > found[2]
    sure = probabilities([fitted_like([good]), fitted_like([2 * good])])
    assert sure == pytest.approx([1.0, 0.0], abs=1e-9)


def test_a_tie_is_half_each():
    e = noise(1)
    assert probabilities([fitted_like([e]), fitted_like([e])]) == pytest.approx([0.5, 0.5])
    nearly = probabilities([fitted_like([e]), fitted_like([e + noise(2, 1e-4)])])
    assert nearly == pytest.approx([0.5, 0.5], abs=0.1)


def test_more_parameters_for_the_same_fit_lose():
    e = noise(1)
    few, many = fitted_like([e], free=1), fitted_like([e], free=9)
    assert probability_over(few, many) > 0.99
    assert probability_over(many, few) < 0.01


def test_the_same_odds_say_less_where_they_hang_on_the_penalty():
    e = noise(1)
    penalty = 0.5 * np.log(len(e))
    odds = []
    for more in (0, 2):
        simple, other = fitted_like([e]), fitted_like([e], free=1 + more)
        other.log_prior = more * penalty - 4.0  # behind by four nats either way
        odds.append(probability_over(simple, other))
    assert 0.95 < odds[0] < 0.99
    assert 0.8 < odds[1] < 0.95


def test_one_lucky_window_does_not_decide():
    e, other = noise(1), noise(1)
    other[:WINDOW] *= 1.5
    steady = noise(1) * 1.05
    lucky = probability_over(fitted_like([e]), fitted_like([other]))
    assert 0.5 < lucky < 0.95
    assert probability_over(fitted_like([e]), fitted_like([steady])) > 0.999


@pytest.fixture(scope="module")
def stated():
    """Probabilities of two predictions of which one is exact, and whether the likelier one was."""
    draw, out = rng(3), []
    between = tones(48 * WINDOW, seed=4)
    between /= np.sqrt(np.sum(between**2))
    for _ in range(1000):
        apart = draw.uniform(0.5, 4.0)  # standard deviations of noise
        e = draw.standard_normal((48 * WINDOW, 1))
        exact, off = fitted_like([e]), fitted_like([e + apart * between[:, None]])
        p = probability_over(exact, off)
        out.append((max(p, 1 - p), p > 0.5))
    return np.array(out)


@pytest.mark.parametrize(("low", "high"), [(0.6, 0.75), (0.75, 0.85), (0.85, 0.95)])
def test_a_probability_is_the_share_that_is_right_where_one_of_two_is_exact(stated, low, high):
    p, right = stated[(stated[:, 0] >= low) & (stated[:, 0] < high)].T
    assert len(p) > 90
    spread = np.sqrt(np.mean(p * (1 - p)) / len(p))
    assert np.mean(right) == pytest.approx(np.mean(p), abs=0.01 + 2 * spread)
    if high == 0.95:
        assert 0.85 < np.mean(right) < 0.95


def test_what_scatters_beyond_noise_makes_unsure():
    e, other = noise(1), noise(1)
    for number in range(8):
        window = slice(number * WINDOW, (number + 1) * WINDOW)
        other[window] *= 1.3 if number % 2 else 0.82
    found = probability_over(fitted_like([e]), fitted_like([other]))
    ratio = windows(fitted_like([e])).sum() - windows(fitted_like([other])).sum()
    assert ratio > 20.0  # odds of a billion, were one of them exact
    assert 0.5 < found < 0.95


def test_no_fits_have_no_probabilities():
    assert probabilities([]) == []
