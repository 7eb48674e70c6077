"""Fourteen ways in which instruments misbehave, each of a strength, on recordings of two floors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import bilinear, lfilter

from experiments.concealed.chain import delayed

Array = NDArray[np.float64]
Columns = dict[str, Array]
STRENGTHS = (0.3, 1.0, 3.0)


@dataclass(frozen=True)
class Setting:
    """What a nuisance is made with.

    Attributes:
        strength: 1 is what a laboratory would notice afterwards.
        rate: samples per second.
        rng: of its draws.
    """

    strength: float
    rate: float
    rng: np.random.Generator


def rms(x: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(x**2)))


def hum(c: Columns, s: Setting) -> Columns:
    """50 Hz on both accelerometers, 3 % of RMS."""
    return _both(c, lambda x: 0.03 * s.strength * rms(x) * np.sqrt(2) * np.sin(
        2 * np.pi * 50 * np.arange(len(x)) / s.rate + s.rng.uniform(0, 6)))  # fmt: skip


def pink(c: Columns, s: Setting) -> Columns:
    """1/f noise on both accelerometers, 2 % of RMS."""

    def noise(x: Array) -> Array:
        spectrum = np.fft.rfft(s.rng.standard_normal(len(x)))
        spectrum[1:] /= np.sqrt(np.arange(1, len(spectrum)))
        spectrum[0] = 0
        slow = np.fft.irfft(spectrum, len(x))
        return np.asarray(0.02 * s.strength * rms(x) * slow / rms(slow))

    return _both(c, noise)


def bend(c: Columns, s: Setting) -> Columns:
    """Baselines that bend by a fifth of RMS over a recording."""
    return _both(c, lambda x: 0.2 * s.strength * rms(x) * (
        4 * (np.arange(len(x)) / len(x) - 0.5) ** 2 - 1 / 3))  # fmt: skip


def crosstalk(c: Columns, s: Setting) -> Columns:
    """2 % of each accelerometer in the other."""
    a, b, share = c["acc_floor1"], c["acc_floor2"], 0.02 * s.strength
    return c | {"acc_floor1": a + share * b, "acc_floor2": b + share * a}


def dropout(c: Columns, s: Setting) -> Columns:
    """Twenty samples held in each channel."""

    def held(x: Array) -> Array:
        out, length = x.copy(), max(round(20 * s.strength), 3)
        first = int(s.rng.integers(len(x) // 4, len(x) // 2))
        out[first : first + length] = out[first]
        return out

    return {n: held(x) if n.startswith("acc") else x for n, x in c.items()}


def quantised(c: Columns, s: Setting) -> Columns:
    """Seven bits over the range of the recording."""

    def coarse(x: Array) -> Array:
        step = 2 * np.max(np.abs(x)) / 2**7 * s.strength
        return np.asarray(step * np.round(x / step))

    return {n: coarse(x) if n.startswith("acc") else x for n, x in c.items()}


def spikes(c: Columns, s: Setting) -> Columns:
    """Twelve spikes a channel, of three times its RMS."""

    def crackle(x: Array) -> Array:
        out = np.zeros(len(x))
        at = s.rng.choice(len(x) - 2, 12, replace=False) + 1
        out[at] = 3 * s.strength * rms(x) * s.rng.choice([-1.0, 1.0], 12)
        return out

    return _both(c, crackle)


def resonance(c: Columns, s: Setting) -> Columns:
    """A loosely mounted sensor at floor 2, which resonates at 60 Hz or above."""
    w, zeta = 2 * np.pi * 60 / np.sqrt(s.strength), 0.03
    b, a = bilinear([2 * zeta * w, w**2], [1, 2 * zeta * w, w**2], s.rate)
    return c | {"acc_floor2": np.asarray(lfilter(b, a, c["acc_floor2"]))}


def offset(c: Columns, s: Setting) -> Columns:
    """A constant of a fifth of RMS on floor 1."""
    return c | {"acc_floor1": c["acc_floor1"] + 0.2 * s.strength * rms(c["acc_floor1"])}


def gain(c: Columns, s: Setting) -> Columns:
    """An accelerometer calibrated 3 % off."""
    return c | {"acc_floor2": c["acc_floor2"] * (1 + 0.03 * s.strength)}


def late(c: Columns, s: Setting) -> Columns:
    """A channel half a millisecond late."""
    return c | {"acc_floor1": delayed(c["acc_floor1"], 5e-4 * s.strength, s.rate)}


def saturated(c: Columns, s: Setting) -> Columns:
    """A range that ends at 2.5 RMS of floor 1."""
    level = 2.5 * rms(c["acc_floor1"]) / s.strength**0.3
    return c | {"acc_floor1": np.clip(c["acc_floor1"], -level, level)}


def dead(c: Columns, s: Setting) -> Columns:
    """A cable that comes off for the last tenth of a recording."""
    out = c["acc_floor2"].copy()
    first = round(len(out) * (1 - 0.1 * s.strength))
    out[first:] = out[first]
    return c | {"acc_floor2": out}


def wandering(c: Columns, s: Setting) -> Columns:
    """A random walk on floor 2 that comes to a tenth of RMS."""
    x = c["acc_floor2"]
    walk = np.cumsum(s.rng.standard_normal(len(x))) / np.sqrt(len(x))
    return c | {"acc_floor2": x + 0.1 * s.strength * rms(x) * walk}


Change = Callable[[Columns, Setting], Columns]

NUISANCES: dict[str, tuple[Change, tuple[str, ...]]] = {
    "hum": (hum, ("acc_floor1", "acc_floor2")),
    "pink noise": (pink, ("acc_floor1", "acc_floor2")),
    "bent baseline": (bend, ("acc_floor1", "acc_floor2")),
    "crosstalk": (crosstalk, ("acc_floor1", "acc_floor2")),
    "dropout": (dropout, ("acc_floor1", "acc_floor2")),
    "quantisation": (quantised, ("acc_floor1", "acc_floor2")),
    "spikes": (spikes, ("acc_floor1", "acc_floor2")),
    "resonance": (resonance, ("acc_floor2",)),
    "offset": (offset, ("acc_floor1",)),
    "gain": (gain, ("acc_floor2",)),
    "late": (late, ("acc_floor1",)),
    "saturation": (saturated, ("acc_floor1",)),
    "dead tail": (dead, ("acc_floor2",)),
    "random walk": (wandering, ("acc_floor2",)),
}
"""What is wrong, and the channels that have it."""

AT_SENSOR = frozenset({"resonance", "late"})
"""What happens to the accelerations before any filter and sampler. Done to the samples, a bilinear
rule would bend the resonance near half their rate, and a shift would take for band-limited what no
filter has limited: neither is what an instrument does."""


def _both(c: Columns, added: Callable[[Array], Array]) -> Columns:
    return {n: x + added(x) if n.startswith("acc") else x for n, x in c.items()}
