"""Small rigs whose truth is known, and an integration that shares no code with the twin."""

import numpy as np
from scipy.integrate import solve_ivp

from twin.diagnosis.plant import build, sampled
from twin.diagnosis.trials import Trial
from twin.model import Twin
from twin.recording import Recording
from twin.second_order import SecondOrderModel

RATE = 128.0
M1, R1, K1 = 2.0, 1.2, 800.0
ONE = SecondOrderModel([[M1]], [[R1]], [[K1]], ("floor1",))
TWO = SecondOrderModel(
    np.diag([1.5, 1.2]),
    [[1.5, -0.7], [-0.7, 0.7]],
    [[1300.0, -600.0], [-600.0, 600.0]],
    ("floor1", "floor2"),
)


def rng(seed=0):
    return np.random.default_rng(seed)


def rough(samples, seed=0, scale=1.0):
    """White noise that is zero at first, (samples,)."""
    force = scale * rng(seed).standard_normal(samples)
    force[0] = 0.0
    return force


def tones(samples, rate=RATE, seed=0, scale=1.0, frequencies=(0.9, 1.7, 2.6, 4.1, 6.3, 8.7)):
    """A smooth force that begins at nothing, (samples,)."""
    t = np.arange(samples) / rate
    phase = rng(seed).uniform(0, 2 * np.pi, len(frequencies))
    total = sum(np.sin(2 * np.pi * f * t + p) for f, p in zip(frequencies, phase, strict=True))
    return scale * (1 - np.exp(-t / 0.3)) * total


def motion(model, forces, rate=RATE, held=False, law=None, b=None, start=None):
    """Displacements, rates and accelerations of M x'' + R x' + K x + b law(d, v) = forces.

    Args:
        model: M, R, K; forces: (samples, n), straight lines (or held) between the samples.
        law: f(drift, rate), along b; start: displacements and rates at the first sample, (2n,).
    """
    n, inverse = len(model.M), np.linalg.inv(model.M)
    b = np.zeros(n) if b is None else np.asarray(b, float)

    def slope(t, state, first, change):
        x, v = state[:n], state[n:]
        f = 0.0 if law is None else law(b @ x, b @ v)
        push = first + change * (t * rate)
        return np.concatenate([v, inverse @ (push - model.R @ v - model.K @ x - b * f)])

    states = np.zeros((len(forces), 2 * n))
    if start is not None:
        states[0] = start
    for k in range(len(forces) - 1):
        change = np.zeros(n) if held else forces[k + 1] - forces[k]
        found = solve_ivp(
            slope, (0, 1 / rate), states[k], "DOP853", args=(forces[k], change),
            rtol=1e-11, atol=1e-14,
        )  # fmt: skip
        states[k + 1] = found.y[:, -1]
    zero = np.zeros(n)
    acc = [slope(0.0, s, f, zero)[n:] for s, f in zip(states, forces, strict=True)]
    return states[:, :n], states[:, n:], np.array(acc)


def recorded(
    twin, seed=0, scale=0.3, seconds=12.0, rate=RATE, noise=2e-3, source=None, at="floor2",
    kinds=("acc",),
):  # fmt: skip
    """A recording of a twin that is pushed by smooth noise, accelerometers with white noise."""
    fine, samples = 8, round(seconds * rate)
    t = np.arange(samples * fine) / (rate * fine)
    draw = rng(seed)
    f = np.linspace(0.3, 12.0, 160)
    phase = draw.uniform(0, 2 * np.pi, len(f))
    force = scale * np.sqrt(2 / len(f)) * np.cos(2 * np.pi * f * t[:, None] + phase).sum(axis=1)
    force *= 1 - np.exp(-t / 0.2)
    moved = twin.simulate({f"force_{at}": force}, rate * fine, len(force)).columns
    columns = {f"force_{at}": force[::fine]}
    for kind in kinds:
        for floor in twin.floors:
            clean = moved[f"{kind}_{floor}"][::fine]
            columns[f"{kind}_{floor}"] = clean + noise * draw.standard_normal(samples)
    return Recording.build(rate, columns, source or f"seed{seed}.csv")


def lumped(*mechanisms):
    twin = Twin.load("two_storey_lumped")
    return twin.including(*mechanisms) if mechanisms else twin


def error(found, true):
    """RMS of the difference over RMS of the truth."""
    return float(np.sqrt(np.mean((found - true) ** 2) / np.mean(np.square(true))))


def exact_trial(
    mechanisms=(), model=TWO, seed=0, noise=1e-4, samples=768, start=None, rate=RATE, source=None
):
    """A trial of a linear plant that is pushed at every floor, its accelerometers noisy."""
    n = len(model.M)
    inputs = tuple(f"force_floor{i + 1}" for i in range(n))
    outputs = tuple(f"acc_floor{i + 1}" for i in range(n))
    plant = sampled(build(model, mechanisms, inputs, outputs), 1 / rate)
    u = np.column_stack([tones(samples, rate, seed + 50 * i) for i in range(n)])
    after = np.vstack([u[1:], u[-1:]])
    x, y = np.zeros(len(plant.A)) if start is None else np.asarray(start, float), []
    for k in range(samples):
        y.append(plant.plant.C @ x + plant.plant.D @ u[k])
        x = plant.A @ x + plant.B0 @ u[k] + plant.B1 @ after[k]
    y = np.array(y) + noise * rng(seed + 1000).standard_normal((samples, n))
    levels = np.full(n, 1e-9), np.full(n, max(noise, 1e-9))
    return Trial(source or f"seed{seed}", rate, inputs, outputs, u, y, *levels)


def concealed(law, b, seed, model=None, scale=0.6, seconds=12.0, noise=2e-3):
    """A recording of a frame with a law f(drift, rate) along b that no mechanism has."""
    model = lumped().second_order() if model is None else model
    fine, samples, n = 8, round(seconds * RATE), len(model.M)
    rate, inverse = RATE * fine, np.linalg.inv(model.M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ model.K, -inverse @ model.R]])
    push = np.concatenate([np.zeros(n), inverse[:, -1]])
    kick = np.concatenate([np.zeros(n), inverse @ b])
    force = tones(samples * fine, rate, seed, 0.5 * scale)

    def slope(s, u):
        return A @ s + push * u - kick * law(b @ s[:n], b @ s[n:])

    s, h, acc = np.zeros(2 * n), 1 / rate, np.empty((samples, n))
    for k in range(samples * fine - 1):
        u, after = force[k], force[k + 1]
        first = slope(s, u)
        if k % fine == 0:
            acc[k // fine] = first[n:]
        second = slope(s + h / 2 * first, (u + after) / 2)
        third = slope(s + h / 2 * second, (u + after) / 2)
        s = s + h / 6 * (first + 2 * second + 2 * third + slope(s + h * third, after))
    acc += noise * rng(seed + 500).standard_normal(acc.shape)
    columns = {"force_floor2": force[::fine], "acc_floor1": acc[:, 0], "acc_floor2": acc[:, 1]}
    return Recording.build(RATE, columns, f"seed{seed}.csv")
