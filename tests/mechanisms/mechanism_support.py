"""An integration of the equations of motion that shares no code with MuJoCo."""

import numpy as np

RATE = 1000
SAMPLES = 1500


def push(samples=SAMPLES, seed=0):
    """A smooth force with both modes of the two-storey frame in it [N], (samples,)."""
    t = np.arange(samples) / RATE
    phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, 4)
    tones = zip((1.3, 1.9, 4.0, 6.5), phase, strict=True)
    return 0.4 * sum(np.sin(2 * np.pi * f * t + p) - np.sin(p) for f, p in tones)


def integrate(model, forces, law=None, fine=4):
    """Displacements and accelerations of M q'' + R q' + K q + p f = u, u linear in between.

    Args:
        model: M, R, K and ports; forces on q: (samples, n); law: at a port p; fine: steps a sample.
    """
    n, dt = len(model.M), 1 / (RATE * fine)
    inverse = np.linalg.inv(model.M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ model.K, -inverse @ model.R]])
    B = np.vstack([np.zeros((n, n)), inverse])
    b = np.zeros(n) if law is None else model.port(law.place)
    kick = B @ b

    def slope(state, u, time, memory, before):
        rate = A @ state + B @ u
        if law is None:
            return rate
        drift = b @ state[:n]
        z = sum(law.remember(memory, before, drift)) if law.memory else 0.0
        return rate - kick * law.force(drift, b @ state[n:], z, time)

    memory = np.zeros(law.memory if law else 0)
    state, states, rates = np.zeros(2 * n), [], []
    samples = np.arange(len(forces))
    steps = np.arange(len(forces) * fine) / fine
    fine_forces = np.column_stack([np.interp(steps, samples, f) for f in forces.T])
    last = (len(forces) - 1) * fine
    for k in range(last + 1):
        u, time, before = fine_forces[k], k * dt, b @ state[:n]
        k1 = slope(state, u, time, memory, before)
        if k % fine == 0:
            states.append(state)
            rates.append(k1)
        if k == last:
            break
        after = fine_forces[k + 1]
        middle = (u + after) / 2
        k2 = slope(state + dt / 2 * k1, middle, time + dt / 2, memory, before)
        k3 = slope(state + dt / 2 * k2, middle, time + dt / 2, memory, before)
        k4 = slope(state + dt * k3, after, time + dt, memory, before)
        state = state + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        if law is not None and law.memory:
            memory = law.remember(memory, before, b @ state[:n])
    return np.array(states)[:, :n], np.array(rates)[:, n:]


def readings(model, inputs, law=None, fine=4):
    """Outputs of a LinearModel with a law at a port: the mean of what it is at rest left out."""
    forces = inputs @ model.B.T
    q, acceleration = integrate(model, forces, law, fine)
    speed = np.gradient(q, 1 / RATE, axis=0) if np.any(model.Cv) else 0 * q
    return q @ model.Cd.T + speed @ model.Cv.T + acceleration @ model.Ca.T + inputs @ model.Cu.T


def error(found, true):
    """RMS of the difference over RMS of the truth."""
    return float(np.sqrt(np.mean((found - true) ** 2) / np.mean(true**2)))
