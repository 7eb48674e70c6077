"""The paper's frame, and a linear closed loop that scipy simulates."""

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

    Returns displacements and angle at every physics step, the torques that acted, the estimates.
    """
    system = model.continuous()
    n = len(model.structure.M)
    full = signal.StateSpace(system.A, system.B, np.eye(2 * n), np.zeros((2 * n, 2)))
    samples = (len(force) - 1) // inner
    time = np.arange(inner + 1) * controller.dt / inner
    steps, state, torque = controller.start(), np.zeros(2 * n), 0.0
    given, motion, torques, estimates = [], [], [], []
    for k in range(samples):
        part = force[k * inner : (k + 1) * inner + 1]
        y = system.C @ state + system.D @ [part[0], torque]  # before the torque of k acts
        if k == switch:
            steps.switch(True)
        given.append(steps.step(y, part[0]))
        torque = given[k - delay] if k >= delay else 0.0
        estimates.append(steps.estimate())
        inputs = np.column_stack([part, np.full(inner + 1, torque)])
        _, _, states = signal.lsim(full, inputs, time, state)
        state = states[-1]
        motion.append(states[:-1])
        torques.append(torque)
    motion = np.vstack(motion)
    rows = np.vstack([model.displacements(), np.eye(2 * n)[model.index("pendulum")]])
    return motion @ rows.T, np.array(torques), np.array(estimates)
