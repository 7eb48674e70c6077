import tracemalloc

import numpy as np
import pytest

from twin.errors import IdentificationError
from twin.identification import okid as module
from twin.identification.okid import okid


def random_records(samples=400, inputs=2, outputs=3, seed=0):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((samples, inputs)), rng.standard_normal((samples, outputs))


def data_matrix(u, y, p):
    """Equation (27), written out."""
    v = np.hstack([u, y])
    rows = [u.T]
    for lag in range(1, p + 1):
        rows.append(np.vstack([np.zeros((lag, v.shape[1])), v[:-lag]]).T)
    return np.vstack(rows)


def stacked(markov):
    D, Y1, Y2 = markov.D, markov.Y1, markov.Y2
    return np.hstack([D, *[np.hstack([a, -b]) for a, b in zip(Y1, Y2, strict=True)]])


def test_lag_products_give_the_pseudoinverse_solution_of_equation_28():
    u, y = random_records()
    expected = y.T @ np.linalg.pinv(data_matrix(u, y, 6))
    np.testing.assert_allclose(stacked(okid([(u, y)], 6)), expected, atol=1e-12)


def test_without_rest_the_first_p_samples_are_only_history():
    u, y = random_records()
    expected = y.T[:, 6:] @ np.linalg.pinv(data_matrix(u, y, 6)[:, 6:])
    np.testing.assert_allclose(stacked(okid([(u, y)], 6, at_rest=False)), expected, atol=1e-12)


def test_several_records_are_one_least_squares_problem():
    one, two = random_records(seed=1), random_records(250, seed=2)
    V = np.hstack([data_matrix(*one, 4), data_matrix(*two, 4)])
    Y = np.hstack([one[1].T, two[1].T])
    np.testing.assert_allclose(stacked(okid([one, two], 4)), Y @ np.linalg.pinv(V), atol=1e-12)


def test_ill_conditioned_records_go_through_qr_and_keep_their_digits():
    u, y = random_records(20_000, 1, 1)
    u = np.hstack([u, u + 1e-6 * random_records(20_000, 1, 1, seed=9)[0]])
    exact = np.array([[1.0, 2.0]])
    y = u @ exact.T
    assert np.abs(okid([(u, y)], 1).D - exact).max() < 1e-8


def test_markov_parameters_are_the_impulse_response_of_the_true_system(frame):
    model = frame.acceleration_response(("floor1",)).held(1 / 32)
    rng = np.random.default_rng(3)
    u = rng.standard_normal((500, 1))
    markov = okid([(u, model.simulate(u))], 2).markov(50)
    pulse = np.zeros((51, 1))
    pulse[0] = 1
    np.testing.assert_allclose(markov[:, :, 0], model.simulate(pulse), atol=1e-9)


def test_observer_gain_parameters_follow_equation_30(frame):
    model = frame.acceleration_response(("floor1",)).held(1 / 32)
    u = np.random.default_rng(4).standard_normal((500, 1))
    observer = okid([(u, model.simulate(u))], 2)
    markov = observer.markov(5)[:, :, 1:]
    Y2 = observer.Y2
    np.testing.assert_allclose(markov[1], Y2[0])
    np.testing.assert_allclose(markov[2], Y2[1] - Y2[0] @ markov[1])
    np.testing.assert_allclose(markov[3], -(Y2[0] @ markov[2] + Y2[1] @ markov[1]))


def test_an_observer_longer_than_noise_free_data_determine_is_reported(frame):
    model = frame.acceleration_response(("floor1",)).held(1 / 32)
    u = np.random.default_rng(5).standard_normal((500, 1))
    y = model.simulate(u)
    assert not okid([(u, y)], 2).rank_deficient
    assert okid([(u, y)], 3).rank_deficient


def test_too_few_samples_say_how_long_an_observer_may_be():
    u, y = random_records(30)
    with pytest.raises(IdentificationError, match=r"30 usable samples .* p of at most 5"):
        okid([(u, y)], 10)


@pytest.mark.parametrize("at_rest", [True, False])
def test_memory_does_not_grow_with_the_record_times_the_observer_length(at_rest):
    u, y = random_records(100_000, 1, 2)
    p = 60
    tracemalloc.start()
    okid([(u, y)], p, at_rest)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    record, gram = u.nbytes + y.nbytes, 8 * (3 * (p + 1)) ** 2
    assert peak < 2 * record + 5 * gram


def test_the_gram_matrix_is_that_of_the_shifted_records():
    w = np.hstack(random_records(50, 2, 3))
    for p, at_rest in ((7, True), (7, False), (60, True)):
        rows = module._shifted(w, p, 0 if at_rest else p, 50)
        flat = module._gram(w, p, at_rest).reshape(rows.shape[1], rows.shape[1])
        np.testing.assert_allclose(flat, rows.T @ rows, atol=1e-12)


@pytest.mark.parametrize("method", ["normal equations", "QR"])
def test_what_drives_the_columns_is_the_input_and_what_the_observer_leaves(monkeypatch, method):
    if method == "QR":
        monkeypatch.setattr(module, "WELL_CONDITIONED", 1.0)
    u, y = random_records()
    found = okid([(u, y)], 6)
    left = y.T - stacked(found) @ data_matrix(u, y, 6)
    expected = np.concatenate([np.mean(u**2, axis=0), np.mean(left**2, axis=1)])
    np.testing.assert_allclose(found.driving**2, expected)
