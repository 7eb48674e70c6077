"""The paper's frame, and a linear closed loop that scipy simulates."""

from itertools import pairwise

import numpy as np
from scipy import signal

from twin.second_order import SecondOrderModel

PAPER_FRAME = SecondOrderModel(
    np.array([[1.3005, -0.0846], [-0.0846, 0.5663]]),
    np.array([[0.3955, -0.0485], [-0.0485, 0.1838]]),
    np.array([[1047.3, -824.1], [-824.1, 841.6]]),
    ("floor1", "floor2"),
)


def linear_run(model, controller, force, inner, delay, switch=0):
    """Simulate the linear plant by scipy.signal.lsim, sample by sample.

    The delay may end between samples, at one of the ``inner`` steps. Returns displacements and
    angle at every physics step, the torques that acted from each sample on, the estimates.
    """
    states, torques, estimates, _ = linear_states(model, controller, force, inner, delay, switch)
    n = len(model.structure.M)
    rows = np.vstack([model.displacements(), np.eye(2 * n)[model.index("pendulum")]])
    return states @ rows.T, torques, estimates


def linear_states(model, controller, force, inner, delay, switch=0):
    """The same, with the state at every physics step and the torques as they were given."""
    system = model.continuous()
    n = len(model.structure.M)
    full = signal.StateSpace(system.A, system.B, np.eye(2 * n), np.zeros((2 * n, 2)))
    samples, late = (len(force) - 1) // inner, round(delay * inner)
    steps, state, torque = controller.start(), np.zeros(2 * n), 0.0
    given, motion, torques, estimates = [], [], [], []
    for k in range(samples):
        y = system.C @ state + system.D @ [force[k * inner], torque]  # before a torque of k acts
        if k == switch:
            steps.switch(True)
        given.append(steps.step(y, force[k * inner]))
        estimates.append(steps.estimate())
        edges = sorted({k * inner, k * inner + late % inner, (k + 1) * inner})
        for begin, end in pairwise(edges):
            acting = (begin - late) // inner
            torque = given[acting] if acting >= 0 else 0.0
            if begin == k * inner:
                torques.append(torque)
            time = np.arange(end - begin + 1) * controller.dt / inner
            inputs = np.column_stack([force[begin : end + 1], np.full(len(time), torque)])
            if len(time) == 2:  # lsim wants three instants at least
                time = np.array([0, time[1] / 2, time[1]])
                inputs = np.vstack([inputs[0], inputs.mean(axis=0), inputs[1]])
                states = signal.lsim(full, inputs, time, state)[2][[0, 2]]
            else:
                states = signal.lsim(full, inputs, time, state)[2]
            motion.append(states[:-1])
            state = states[-1]
    return np.vstack(motion), np.array(torques), np.array(estimates), np.array(given)
