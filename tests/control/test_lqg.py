import control
import numpy as np
import pytest
from scipy import linalg, signal

from twin.control.absorber import DesignModel, with_pendulum
from twin.control.lqg import lqg
from twin.control.riccati import gains
from twin.control.weights import Covariances, Weights
from twin.errors import ControlError
from twin.frame import Pendulum
from twin.second_order import SecondOrderModel

DT = 1 / 32
WEIGHTS = Weights(2.0, 0.3, 0.04, 0.005, 0.006)
COVARIANCES = Covariances(0.03, 2e-3, 4e-3, 0.05, 2e-3)


def held(model, T):
    """Sampled state matrix and influence of forces held between samples, by scipy."""
    s = model.structure
    n = len(s.M)
    B = np.vstack([np.zeros_like(T), np.linalg.solve(s.M, T)])
    A, B, *_ = signal.cont2discrete(
        (s.state_matrix(), B, np.eye(2 * n), np.zeros((2 * n, T.shape[1]))), DT
    )
    return A, B


def state_weight():
    Q = np.zeros((6, 6))
    Q[0, 0] = Q[1, 1] = WEIGHTS.displacement
    Q[3, 3] = Q[4, 4] = WEIGHTS.velocity
    Q[2, 2], Q[5, 5] = WEIGHTS.angle, WEIGHTS.angular_rate
    return Q


def test_the_regulator_is_that_of_python_control(paper_model):
    found = gains(paper_model, DT, WEIGHTS, COVARIANCES)
    A, B = held(paper_model, np.array([[0.0], [0.0], [1.0]]))
    F, cost, _ = control.dlqr(A, B, state_weight(), WEIGHTS.torque)
    assert np.allclose(found.F, F, rtol=1e-6)
    assert np.allclose(found.cost, cost, rtol=1e-6)


def test_the_regulator_solves_its_riccati_equation(paper_model):
    found = gains(paper_model, DT, WEIGHTS, COVARIANCES)
    A, B = held(paper_model, np.array([[0.0], [0.0], [1.0]]))
    S = found.cost
    residual = state_weight() + A.T @ S @ (A - B @ found.F) - S
    assert np.abs(residual).max() < 1e-9 * np.abs(S).max()


def test_the_estimators_error_has_the_covariance_it_claims(paper_model):
    """Two thousand estimators side by side, disturbed as the design assumes."""
    found = gains(paper_model, DT, WEIGHTS, COVARIANCES)
    n = 3
    T = np.column_stack([np.diag([0.03, 0.03, 2e-3]), 4e-3 * np.array([1.0, 0, 0])])
    A, G = held(paper_model, T)
    C = paper_model.continuous().C
    direct = np.vstack([np.linalg.solve(paper_model.structure.M, T)[:2], np.zeros((1, n + 1))])
    noise = np.array([[0.05], [0.05], [2e-3]])
    rng = np.random.default_rng(1)
    error = np.zeros((6, 2000))
    for _ in range(600):
        w, v = rng.normal(size=(n + 1, 2000)), noise * rng.normal(size=(n, 2000))
        error = A @ error + G @ w
        error = error - found.L @ (C @ error + direct @ w + v)
    ours = np.cov(error)
    scale = np.sqrt(np.outer(np.diag(found.P), np.diag(found.P)))
    assert np.abs((ours - found.P) / scale).max() < 0.12


def test_the_estimator_is_that_of_python_control_with_the_disturbance_as_a_state(paper_model):
    """[z, w] with w(k-1) beside z(k): nothing is correlated any more."""
    found = gains(paper_model, DT, WEIGHTS, COVARIANCES)
    T = np.column_stack([np.diag([0.03, 0.03, 2e-3]), 4e-3 * np.array([1.0, 0, 0])])
    A, G = held(paper_model, T)
    C = paper_model.continuous().C
    direct = np.vstack([np.linalg.solve(paper_model.structure.M, T)[:2], np.zeros((1, 4))])
    both_A = np.block([[A, np.zeros((6, 4))], [np.zeros((4, 10))]])
    both_C = np.hstack([C, direct])
    R = np.diag([0.05, 0.05, 2e-3]) ** 2
    _, P, _ = control.dlqe(both_A, np.vstack([G, np.eye(4)]), both_C, np.eye(4), R)
    L = P @ both_C.T @ np.linalg.inv(both_C @ P @ both_C.T + R)
    assert np.allclose(found.L, L[:6], rtol=1e-5, atol=1e-7)
    after = (np.eye(10) - L @ both_C) @ P
    assert np.allclose(found.P, after[:6, :6], rtol=1e-4, atol=1e-6 * np.abs(found.P).max())


def test_a_lag_of_one_sample_gives_equation_59(paper_model):
    """z(k+1) = A z + B_e f + B_c u + K (y - C z - D_e f - D_c u), u = -F z, written out."""
    controller = lqg(paper_model, 32.0, WEIGHTS, COVARIANCES, 1.0, "constant", 1e9, 0.0)
    found = gains(paper_model, DT, WEIGHTS, COVARIANCES)
    A, B_e = held(paper_model, np.array([[1.0], [0], [0]]))
    _, B_c = held(paper_model, np.array([[0.0], [0], [1]]))
    model = paper_model.continuous()
    rng = np.random.default_rng(2)
    steps = controller.start()
    steps.switch(True)
    z, u, u_before = np.zeros(6), 0.0, 0.0
    for _ in range(50):
        y, f = rng.normal(size=3), rng.normal()
        # the measurement is taken just before the torque of this instant acts
        innovation = y - model.C @ z - model.D @ [f, u_before]
        z = A @ (z + found.L @ innovation) + B_e[:, 0] * f + B_c[:, 0] * u
        u_before, u = u, -float(found.F[0] @ z)
        assert steps.step(y, f) == pytest.approx(u, rel=1e-9, abs=1e-12)


def test_without_a_delay_the_filtered_estimate_is_fed_back(paper_model):
    controller = lqg(paper_model, 32.0, WEIGHTS, COVARIANCES, 0.0, "constant", 1e9, 0.0)
    found = gains(paper_model, DT, WEIGHTS, COVARIANCES)
    steps = controller.start()
    steps.switch(True)
    y = np.array([0.2, -0.1, 0.05])
    expected = -found.F @ (found.L @ y)
    assert steps.step(y, 0.0) == pytest.approx(float(expected[0]), rel=1e-10)


@pytest.mark.parametrize(
    ("rate", "message"),
    [
        (1001.0, "cannot be stepped at 1001 Hz"),
        (0.0, "cannot be stepped at 0 Hz"),
        (float("nan"), "cannot be stepped at nan Hz"),
        (12.0, "12 Hz is too slow: the mode at 6.905 Hz needs more than 13.81 Hz"),
    ],
)
def test_impossible_rates_are_refused(paper_model, rate, message):
    with pytest.raises(ControlError, match=message):
        lqg(paper_model, rate)


@pytest.mark.parametrize("name", ["delay", "torque_limit", "ramp_s"])
def test_impossible_settings_are_refused(paper_model, name):
    with pytest.raises(ControlError, match=r"-1"):
        lqg(paper_model, **{name: -1.0})


def test_negative_weights_are_refused():
    with pytest.raises(ControlError, match="Weights: torque"):
        Weights(torque=-1.0)
    with pytest.raises(ControlError, match="Weights: the torque"):
        Weights(displacement=0.0, velocity=0.0)
    with pytest.raises(ControlError, match="Covariances: measurements"):
        Covariances(acceleration=0.0)


def test_a_mode_out_of_the_torques_reach_is_named():
    """Two equal floors on equal springs, moved alike only: one mode stands still at the top."""
    frame = SecondOrderModel(
        np.eye(2), 0.01 * np.eye(2), np.diag([400.0, 900.0]), ("floor1", "floor2")
    )
    model = DesignModel(with_pendulum(frame, Pendulum()), "force_floor1")
    with pytest.raises(ControlError, match=r"mode at 3\.183 Hz .* 1e-09 is needed"):
        lqg(model)


def test_a_rig_that_floats_cannot_be_held():
    K = np.array([[400.0, -400.0, 0.0], [-400.0, 850.0, -450.0], [0.0, -450.0, 450.0]])
    frame = SecondOrderModel(np.diag([3.0, 0.7, 1.6]), 1e-4 * K, K, ("ground", "floor1", "floor2"))
    with pytest.raises(ControlError, match="the mode at 0 Hz"):
        lqg(DesignModel(with_pendulum(frame, Pendulum()), "force_ground"))


def test_an_unstable_design_model_that_can_be_held_is_held(paper_model):
    """A negative spring is stabilised; the message for one that cannot be is that of its mode."""
    s = paper_model.structure
    K = s.K.copy()
    K[2, 2] = -K[2, 2]
    inverted = DesignModel(SecondOrderModel(s.M, s.R, K, s.coordinates), "force_floor1")
    assert np.abs(inverted.continuous().held(DT).poles).max() > 1
    found = gains(inverted, DT, WEIGHTS, COVARIANCES)
    assert np.abs(np.linalg.eigvals(found.A - found.B @ found.F)).max() < 1


def test_a_solution_that_does_not_stabilise_is_not_taken(paper_model, monkeypatch):
    s = paper_model.structure
    inverted = SecondOrderModel(s.M, s.R, np.diag([1.0, 1, -1]) * s.K, s.coordinates)
    monkeypatch.setattr(linalg, "solve_discrete_are", lambda A, B, *_, **__: 0 * A)
    with pytest.raises(
        ControlError, match=r"unstable design: the regulator has a pole of mag.* 1\."
    ):
        lqg(DesignModel(inverted, "force_floor1"))
