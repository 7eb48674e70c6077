"""Small rigs whose truth is known."""

import numpy as np

from twin.model import Twin
from twin.recording import Recording

RATE = 128.0


def rng(seed=0):
    return np.random.default_rng(seed)


def tones(samples, rate=RATE, seed=0, scale=1.0, frequencies=(0.9, 1.7, 2.6, 4.1, 6.3, 8.7)):
    """A smooth force that begins at nothing, (samples,)."""
    t = np.arange(samples) / rate
    phase = rng(seed).uniform(0, 2 * np.pi, len(frequencies))
    total = sum(np.sin(2 * np.pi * f * t + p) for f, p in zip(frequencies, phase, strict=True))
    return scale * (1 - np.exp(-t / 0.3)) * total


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
