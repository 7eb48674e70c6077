import numpy as np
import pytest

from twin.errors import IdentificationError
from twin.identification import era as module
from twin.identification.era import era


def decaying(count=80, outputs=3, columns=4, seed=0):
    rng = np.random.default_rng(seed)
    return (
        rng.standard_normal((count + 1, outputs, columns))
        * 0.9 ** np.arange(count + 1)[:, None, None]
    )


def hankel(markov, first, rows, columns):
    padded = np.concatenate([markov, np.zeros_like(markov)])
    return np.block([[padded[first + i + j] for j in range(columns)] for i in range(rows)])


def test_the_product_with_the_implicit_hankel_matrix_is_the_product_with_the_matrix():
    markov = decaying()
    vectors = np.random.default_rng(1).standard_normal((40 * 4, 5))
    implicit, dense = module.implicit_hankel(markov[1:], 40, 40), hankel(markov, 1, 40, 40)
    np.testing.assert_allclose(implicit @ vectors, dense @ vectors, atol=1e-12)
    vectors = np.random.default_rng(2).standard_normal((40 * 3, 5))
    np.testing.assert_allclose(implicit.T @ vectors, dense.T @ vectors, atol=1e-12)


@pytest.mark.parametrize("limit", [0, 10_000])
def test_the_state_matrix_is_that_of_equation_38(monkeypatch, limit):
    monkeypatch.setattr(module, "DENSE_LIMIT", limit)
    markov = decaying(60)
    found = era(markov, 25, keep=70)
    root = np.sqrt(found.singular_values[:6])
    shifted = found.R[:, :6].T @ hankel(markov, 2, 25, 35) @ found.S[:, :6]
    expected = shifted / np.outer(root, root)
    np.testing.assert_allclose(found.realize(6, 1.0, 1).A, expected, atol=1e-9)


def test_columns_that_depend_on_each_other_still_get_an_orthonormal_basis():
    rng = np.random.default_rng(3)
    tall = rng.standard_normal((500, 4)) @ rng.standard_normal((4, 20))
    for noise in (0.0, 1e-12, 1e-7, 1.0):
        columns = tall + noise * rng.standard_normal(tall.shape)
        Q = module._orthonormal(columns)
        np.testing.assert_allclose(Q.T @ Q, np.eye(20), atol=1e-13)
        np.testing.assert_allclose(Q @ (Q.T @ columns), columns, atol=1e-9)


def test_a_sketch_finds_the_singular_values_of_the_dense_svd(monkeypatch):
    markov = decaying(200)
    dense = era(markov).singular_values
    monkeypatch.setattr(module, "DENSE_LIMIT", 0)
    np.testing.assert_allclose(era(markov, keep=20).singular_values[:5], dense[:5], rtol=1e-6)


def test_the_realization_reproduces_markov_parameters_of_its_order():
    rng = np.random.default_rng(2)
    A = np.diag([0.9, 0.5, -0.7])
    B, C = rng.standard_normal((3, 2)), rng.standard_normal((2, 3))
    markov = np.array(
        [rng.standard_normal((2, 2))] + [C @ np.linalg.matrix_power(A, k) @ B for k in range(40)]
    )
    model = era(markov).realize(3, 1.0, 2)
    np.testing.assert_allclose(np.sort(model.poles.real), [-0.7, 0.5, 0.9], atol=1e-10)
    np.testing.assert_allclose(model.C @ model.A @ model.A @ model.B, markov[3], atol=1e-10)
    np.testing.assert_array_equal(model.D, markov[0])
    assert model.G is None


def test_an_order_above_the_rank_is_refused_with_the_rank():
    markov = np.zeros((20, 1, 1))
    markov[:, 0, 0] = 0.5 ** np.arange(20)
    with pytest.raises(IdentificationError, match=r"order of 2 is not possible.*rank 1"):
        era(markov).realize(2, 1.0, 1)


def test_too_few_markov_parameters_are_refused():
    with pytest.raises(IdentificationError, match="2 Markov parameters are too few"):
        era(np.ones((3, 1, 1)))


@pytest.mark.parametrize("limit", [0, 10_000])
def test_weighted_columns_give_the_same_exact_model(monkeypatch, limit):
    monkeypatch.setattr(module, "DENSE_LIMIT", limit)
    rng = np.random.default_rng(4)
    A = np.diag([0.9, 0.5, -0.7])
    BG, C = rng.standard_normal((3, 4)), rng.standard_normal((2, 3))
    pulses = [C @ np.linalg.matrix_power(A, k) @ BG for k in range(40)]
    D = rng.standard_normal((2, 2))
    markov = np.array([np.hstack([D, np.zeros((2, 2))]), *pulses])
    model = era(markov, driving=np.array([2.0, 1.0, 0.1, 1e-3])).realize(3, 1.0, 2)
    np.testing.assert_allclose(np.sort(model.poles.real), [-0.7, 0.5, 0.9], atol=1e-10)
    np.testing.assert_allclose(model.D, D)
    np.testing.assert_allclose(model.C @ model.A @ model.B, pulses[1][:, :2], atol=1e-10)
    np.testing.assert_allclose(model.C @ model.A @ model.G, pulses[1][:, 2:], atol=1e-10)
