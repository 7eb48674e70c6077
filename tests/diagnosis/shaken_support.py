"""Chains on a shaken ground, stepped by an integrator of their own, absolute accelerations."""

import numpy as np

from twin.frame import FrameDesign, Ground, Storey
from twin.model import Twin
from twin.recording import Recording

FINE = 16


def chain(masses, stiffnesses, damping=(0.1, 0.03)):
    """A lumped frame of these floors [kg] and storeys [N/m]."""
    storeys = tuple(
        Storey(m, 3.0, 2e11, second_moment=k * 27.0 / 4.8e12)
        for m, k in zip(masses, stiffnesses, strict=True)
    )
    return Twin.of(
        FrameDesign(storeys, kind="lumped", ground=Ground(mass=1.0), damping_ratio=damping)
    )


def ground(seconds, rate, seed, level, band=(0.2, 6.0)):
    """Random ground motion that swells and dies down, at ``rate`` times ``FINE``, (samples,)."""
    draw, t = np.random.default_rng(seed), np.arange(round(seconds * rate * FINE)) / (rate * FINE)
    f = np.linspace(*band, 240)
    phase = draw.uniform(0, 2 * np.pi, len(f))
    wave = sum(np.cos(2 * np.pi * a * t + b) for a, b in zip(f, phase, strict=True))
    return level * np.sqrt(2 / len(f)) * wave * np.sin(np.pi * t / seconds) ** 2


def shaken(masses, stiffnesses, dampers, acc_ground, rate, source, slip=None, noise=1e-4):
    """A recording of a chain whose lowest storey may slip: Bouc-Wen (stiffness, force)."""
    n, h = len(masses), 1 / (rate * FINE)
    rows = np.eye(n) - np.eye(n, k=-1)
    K, C = rows.T @ np.diag(stiffnesses) @ rows, rows.T @ np.diag(dampers) @ rows
    x, v, z = np.zeros(n), np.zeros(n), 0.0
    k, limit = slip or (0.0, 1.0)
    out = []

    def rates(x, v, z, a):
        force = np.zeros(n)
        force[0] = z
        slope = k * v[0] * (1 - (abs(z) / limit) ** 2 * (0.5 + 0.5 * np.sign(v[0] * z)))
        return -(K @ x + C @ v + force) / masses, slope

    for number, a in enumerate(acc_ground):
        if number % FINE == 0:
            out.append(rates(x, v, z, a)[0])
        first, dz = rates(x, v, z, a)
        second, middle = rates(x + h / 2 * v, v + h / 2 * (first - a), z + h / 2 * dz, a)
        x, v, z = x + h * (v + h / 2 * (first - a)), v + h * (second - a), z + h * middle
    draw = np.random.default_rng(len(out))
    columns = {"acc_ground": acc_ground[::FINE]}
    for floor, column in enumerate(np.array(out).T, start=1):
        columns[f"acc_floor{floor}"] = column + noise * draw.standard_normal(len(column))
    return Recording.build(rate, columns, source)
