import numpy as np
import pytest
from absorber_support import linear_run, linear_states

from twin.control.controller import Controller
from twin.control.lqg import lqg
from twin.control.riccati import gains
from twin.control.weights import Covariances, Weights


def gain(limit=10.0, ramp_s=0.0):
    """Torque 2 y, one state that adds up what it gave."""
    return Controller(
        A=[[1.0]],
        B_y=[[0.0]],
        B_f=[0.0],
        B_u=[1.0],
        C=[0.0],
        D_y=[2.0],
        D_f=0.0,
        dt=0.1,
        measurements=("angle_pendulum",),
        known_input="force_floor1",
        estimates=("angle_pendulum",),
        E=[[1.0]],
        torque_limit=limit,
        ramp_s=ramp_s,
    )


def test_no_torque_before_it_is_switched_on():
    steps = gain().start()
    assert steps.step(np.array([1.0]), 0.0) == 0.0
    steps.switch(True)
    assert steps.step(np.array([1.0]), 0.0) == 2.0
    steps.switch(False)
    assert steps.step(np.array([1.0]), 0.0) == 0.0


def test_the_soft_start_rises_in_equal_steps():
    steps = gain(ramp_s=0.4).start()
    steps.switch(True)
    given = [steps.step(np.array([1.0]), 0.0) for _ in range(6)]
    assert given == pytest.approx([0.5, 1.0, 1.5, 2.0, 2.0, 2.0])


def test_switching_on_again_starts_softly_again():
    steps = gain(ramp_s=0.4).start()
    for _ in range(2):
        steps.switch(True)
        given = [steps.step(np.array([1.0]), 0.0) for _ in range(6)]
        assert given[:2] == pytest.approx([0.5, 1.0])


def test_the_torque_is_limited_remembered_as_limited_and_counted():
    steps = gain(limit=1.5).start()
    steps.switch(True)
    assert [steps.step(np.array([y]), 0.0) for y in (1.0, -1.0, 0.5)] == [1.5, -1.5, 1.0]
    assert steps.limited == 2
    assert steps.estimate() == pytest.approx([1.0])


def test_the_estimator_runs_while_the_controller_is_off(controller):
    steps = controller.start()
    steps.step(np.array([0.1, 0.2, 0.3]), 1.0)
    assert np.all(steps.estimate() != 0)


def test_two_runs_do_not_share_a_state(controller):
    first = controller.start()
    first.step(np.array([0.1, 0.2, 0.3]), 1.0)
    assert not controller.start().estimate().any()


def test_a_controller_cannot_be_changed(controller):
    with pytest.raises(ValueError, match="read-only"):
        controller.A[0, 0] = 0.0


@pytest.mark.parametrize("delay", [0.0, 0.5, 1.0, 1.25, 2.5])
def test_the_estimate_follows_the_design_model(believed, delay):
    """Fed with what the model itself gives, there is no error from the first sample on."""
    controller = lqg(believed, delay=delay, ramp_s=0.5)
    rng = np.random.default_rng(0)
    samples = np.append(0.0, rng.normal(size=64))
    force = np.interp(np.arange(257) / 4, np.arange(65), samples)
    motion, torque, estimates = linear_run(believed, controller, force, 4, delay, 20)
    assert np.abs(torque).max() > 0
    assert estimates == pytest.approx(motion[::4], abs=1e-9 * np.abs(motion).max())


@pytest.mark.parametrize("delay", [0.0, 0.5, 1.0, 1.25, 2.5])
def test_the_torque_fits_the_state_at_the_instant_it_acts(believed, delay):
    """Under a constant force, that state can be foretold exactly: u = -F z(t + delay)."""
    settings = Weights(), Covariances()
    controller = lqg(believed, 32.0, *settings, delay, torque_limit=1e9, ramp_s=0.0)
    force = np.minimum(np.arange(40 * 4 + 1) / 40, 1.0)
    states, _, _, given = linear_states(believed, controller, force, 4, delay)
    F = gains(believed, 1 / 32, *settings).F[0]
    late = round(4 * delay)
    acting = np.arange(12, 36) * 4 + late
    assert given[12:36] == pytest.approx(-states[acting] @ F, abs=1e-9 * np.abs(given).max())
