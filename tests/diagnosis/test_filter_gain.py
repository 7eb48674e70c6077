"""The linear filter: gain, recursion, innovations and smoothed states against dense algebra."""

import numpy as np
import pytest
from diagnosis_support import ONE, RATE, TWO, error, rng, rough
from scipy.linalg import solve_discrete_are

from twin import mechanisms
from twin.diagnosis.effects import effect_of_start, effects_of_forces
from twin.diagnosis.filtering import (
    Filtered,
    ahead,
    gain,
    innovations_of,
    linear,
    recursion,
    side_by_side,
    smoothed,
)
from twin.diagnosis.plant import build, sampled

ALL = mechanisms.vocabulary()
INPUTS, OUTPUTS = ("force_floor1", "force_floor2"), ("acc_floor1", "disp_floor2")
NOISE = (np.array([0.03, 0.01]), np.array([0.05, 2e-4]), np.diag([0.2, 0.1]))


def two(*mechanisms, held=True):
    return sampled(build(TWO, mechanisms, INPUTS, OUTPUTS), 1 / RATE, held)


def covariances(plant, input_noise, output_noise, force_noise):
    """State and output noise and their cross term, written out."""
    Su, Sw = np.diag(input_noise**2), force_noise @ force_noise.T
    B, D, L = plant.B0 + plant.B1, plant.plant.D, plant.plant.L
    Q = B @ Su @ B.T + plant.G @ Sw @ plant.G.T + plant.Q
    R = D @ Su @ D.T + L @ Sw @ L.T + np.diag(output_noise**2)
    return Q, R, B @ Su @ D.T + plant.G @ Sw @ L.T


@pytest.mark.parametrize(
    "more", [(), (ALL["unmeasured_force"]("floor1", 0.5, 2.0, 0.4),)], ids=["plain", "disturbed"]
)
def test_the_gain_is_that_of_the_riccati_equation(more):
    plant = two(*more)
    Q, R, S = covariances(plant, *NOISE)
    C = plant.plant.C
    P = solve_discrete_are(plant.A.T, C.T, Q, R, s=S)
    found = gain(plant, *NOISE)
    # unit by unit: states are metres, metres a second and newtons
    size = np.sqrt(np.diag(P))
    scaled = found.predicted / np.outer(size, size)
    np.testing.assert_allclose(scaled, P / np.outer(size, size), atol=5e-5)
    E = C @ P @ C.T + R
    whitened = np.linalg.solve(np.linalg.cholesky(E), found.innovation)
    np.testing.assert_allclose(whitened, np.linalg.cholesky(E).T, atol=1e-5 * np.sqrt(E.max()))
    whole = (plant.A @ P @ C.T + S) @ np.linalg.inv(E)
    per_noise = np.sqrt(np.diag(E)) / size[:, None]
    np.testing.assert_allclose(found.whole(plant.A) * per_noise, whole * per_noise, atol=2e-5)
    carried = S @ np.linalg.inv(E)
    np.testing.assert_allclose(found.carried * per_noise, carried * per_noise, atol=2e-5)
    assert np.abs(carried * per_noise).max() > 0.01, "the test shows something"


def test_noise_that_is_far_greater_in_the_outputs_is_not_listened_to():
    plant = two()
    deaf = gain(plant, NOISE[0] * 1e-6, NOISE[1] * 1e6, NOISE[2] * 1e-6)
    assert np.abs(deaf.whole(plant.A)).max() < 1e-6 * np.abs(gain(plant, *NOISE).filtered).max()


def test_a_frame_that_grows_and_is_not_seen_has_no_gain():
    runaway = ALL["damping"]("storey1", -3.0)
    blind = sampled(build(ONE, (runaway,), ("force_floor1",), ("acc_ground",)), 1 / RATE)
    failing = pytest.raises(np.linalg.LinAlgError, match=r"does not converge|[Ss]ingular")
    with failing, np.errstate(over="ignore", invalid="ignore"):
        gain(blind, np.array([0.1]), np.array([0.1]), np.array([[0.1]]))


MATRICES = {
    "oscillating": np.array([[0.9, 0.3], [-0.3, 0.9]]),
    "real": np.array([[0.5, 1.0, 0.0], [0.0, -0.7, 0.2], [0.0, 0.0, 0.9]]),
    "defective": np.array([[0.8, 1.0, 0.0], [0.0, 0.8, 1.0], [0.0, 0.0, 0.8]]),
    "nilpotent": np.eye(2, k=1),
    "without eigenvectors": np.eye(3, k=1),
    "zero": np.zeros((2, 2)),
    "nearly defective": np.array([[0.8, 1.0], [1e-14, 0.8]]),
    "mixed": np.array([[0.6, 0.7, 1.0], [-0.7, 0.6, 1.0], [0.0, 0.0, 0.3]]),
}


@pytest.mark.parametrize("F", MATRICES.values(), ids=MATRICES)
@pytest.mark.parametrize("at_rest", [True, False], ids=["rest", "moving"])
def test_the_recursion_is_the_loop(F, at_rest):
    g = rng(2).standard_normal((400, len(F)))
    start = None if at_rest else rng(3).standard_normal(len(F))
    x = np.zeros(len(F)) if at_rest else start
    wanted = []
    for row in g:
        wanted.append(x)
        x = F @ x + row
    np.testing.assert_allclose(recursion(F, g, start), wanted, rtol=1e-7, atol=1e-8)


def test_the_next_sample_s_input_repeats_the_last_one():
    np.testing.assert_array_equal(ahead(np.array([[1.0], [2.0], [5.0]]))[:, 0], [2, 5, 5])


def loop(plant, gains, u, y, start):
    """Predict, compare, correct, step: as the filter is told in words."""
    A, C, D = plant.A, plant.plant.C, plant.plant.D
    x, e, states = start, [], []
    for k in range(len(y)):
        states.append(x)
        e.append(y[k] - C @ x - D @ u[k])
        after = u[min(k + 1, len(u) - 1)]
        corrected = x + gains.filtered @ e[-1]
        x = A @ corrected + plant.B0 @ u[k] + plant.B1 @ after + gains.carried @ e[-1]
    return np.array(e), np.array(states)


@pytest.mark.parametrize("held", [True, False], ids=["held", "lines"])
def test_the_linear_filter_is_the_loop(held):
    plant = two(held=held)
    gains = gain(plant, *NOISE)
    u = np.column_stack([rough(300, 1), rough(300, 2)])
    y = rng(4).standard_normal((300, 2)) * [3.0, 1e-3]
    start = np.array([1e-3, -2e-3, 0.05, 0.1])
    found = linear(plant, gains, u, u, y, start)
    e, states = loop(plant, gains, u, y, start)
    assert error(found.innovations, e) < 1e-10
    assert error(found.states, states) < 1e-10


def test_several_plants_side_by_side_are_each_the_loop():
    plants = [two(ALL["stiffness"]("storey1", change)) for change in (0.0, 30.0, -20.0)]
    gains = gain(plants[0], *NOISE)
    u = np.column_stack([rough(300, 1), rough(300, 2)])
    y = rng(4).standard_normal((300, 2)) * [3.0, 1e-3]
    start = np.array([1e-3, -2e-3, 0.05, 0.1])
    found = innovations_of(plants, gains, side_by_side(u, u, y), y, start)
    for plant, innovations in zip(plants, found, strict=True):
        assert error(innovations, loop(plant, gains, u, y, start)[0]) < 1e-10


def test_a_known_force_adds_its_effect_to_the_innovations():
    law = ALL["cubic_stiffness"]("storey2", 1.0)
    plant = two(law, held=False)
    forced = sampled(build(TWO, (), (*INPUTS, "law_0_storey2"), OUTPUTS), 1 / RATE)
    gains = gain(plant, *NOISE)
    u, force = np.column_stack([rough(200, 1), rough(200, 2)]), rough(200, 5)
    y = rng(4).standard_normal((200, 2))
    both = np.column_stack([u, force])
    found = (
        linear(plant, gains, u, u, y).innovations
        + effects_of_forces(plant, gains, 0, force[None])[0]
    )
    assert error(found, linear(forced, gains, both, both, y).innovations) < 1e-10


def test_initial_states_add_their_effects_to_the_innovations():
    plant = two()
    gains = gain(plant, *NOISE)
    u, y = np.zeros((500, 2)), rng(4).standard_normal((500, 2))
    start = np.array([1e-2, -2e-2, 0.5, 1.0])
    effects = np.tensordot(start, effect_of_start(plant, gains, 500), 1)
    found = linear(plant, gains, u, u, y).innovations + effects
    assert error(found, linear(plant, gains, u, u, y, start).innovations) < 1e-8
    assert np.abs(effects).max() > 0.1, "the test shows something"


def dense(plant, noise, y, prior):
    """Means of all states given all outputs, from their joint Gaussian; no inputs."""
    A, C, n, steps = plant.A, plant.plant.C, len(plant.A), len(y)
    Q, R, S = covariances(plant, *noise)
    Q += 1e-13 * np.trace(Q) / n * np.eye(n)
    m = len(C)
    # states and outputs as linear maps of x(0), (w, v)(0), (w, v)(1), ...
    joint = np.block([[Q, S], [S.T, R]])
    total = n + steps * (n + m)
    source = np.zeros((total, total))
    source[:n, :n] = prior
    state = np.hstack([np.eye(n), np.zeros((n, steps * (n + m)))])
    X, Y = [], []
    for k in range(steps):
        at = n + k * (n + m)
        source[at : at + n + m, at : at + n + m] = joint
        X.append(state)
        seen = C @ state
        seen[:, at + n : at + n + m] += np.eye(m)
        Y.append(seen)
        state = A @ state
        state[:, at : at + n] += np.eye(n)
    X, Y = np.vstack(X), np.vstack(Y)
    gains = np.linalg.solve(Y @ source @ Y.T, Y @ source @ X.T).T
    return (gains @ y.ravel()).reshape(steps, n)


def drawn(plant, noise, steps):
    """Outputs of the plant moved by its own noise."""
    Q, R, S = covariances(plant, *noise)
    n = len(plant.A)
    values, vectors = np.linalg.eigh(np.block([[Q, S], [S.T, R]]))
    root = vectors * np.sqrt(np.maximum(values, 0))
    x, y = np.zeros(n), []
    for draw in rng(8).standard_normal((steps, len(root))):
        both = root @ draw
        y.append(plant.plant.C @ x + both[n:])
        x = plant.A @ x + both[:n]
    return np.array(y)


@pytest.mark.parametrize(
    ("channel", "noise"), [("disp_floor1", 2e-3), ("acc_floor1", 0.2)], ids=["disp", "acc"]
)
def test_smoothed_states_are_the_means_of_the_joint_gaussian(channel, noise):
    """An accelerometer feels the force noise at once: state and output noise go together."""
    plant = sampled(build(ONE, (), ("force_floor1",), (channel,)), 1 / 32, held=True)
    levels = (np.array([0.5]), np.array([noise]), np.array([[1.0]]))
    gains = gain(plant, *levels)
    y = drawn(plant, levels, 60)
    zero = np.zeros((60, 1))
    filtered = linear(plant, gains, zero, zero, y)
    wanted = dense(plant, levels, y, gains.predicted)
    found = smoothed(plant, gains, filtered)
    np.testing.assert_allclose(found, wanted, atol=1e-6 * np.abs(wanted).max())
    assert error(filtered.states, wanted) > 0.05, "the test shows something"


def test_smoothing_what_is_already_certain_changes_nothing():
    plant = sampled(build(ONE, (), ("force_floor1",), ("disp_floor1",)), 1 / 32, held=True)
    gains = gain(plant, np.array([1e-9]), np.array([2e-3]), np.array([[1e-9]]))
    x = recursion(plant.A, np.zeros((60, 2)), np.array([1e-2, 0.0]))
    found = smoothed(plant, gains, Filtered(np.zeros((60, 1)), x))
    assert error(found, x) < 1e-6
