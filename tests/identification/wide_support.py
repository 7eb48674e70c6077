"""A structure of many modes under hammer hits, exact between samples that hold their force."""

from __future__ import annotations

import numpy as np
from scipy import signal

RATE = 2048.0
FREQ = np.array([60.0, 95.0, 130.0, 133.0, 210.0, 280.0, 350.0, 420.0, 520.0, 610.0])
ZETA = np.array([0.004, 0.002, 0.001, 0.002, 0.003, 0.001, 0.002, 0.0015, 0.001, 0.002])
OUTPUTS = 4


def poles() -> np.ndarray:
    omega = 2 * np.pi * FREQ
    return omega * (-ZETA + 1j * np.sqrt(1 - ZETA**2))


def record(place: int, samples: int, noise: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """One hit on one of two places: force (samples, 1), accelerations (samples, OUTPUTS)."""
    rng = np.random.default_rng(7)
    shapes = rng.standard_normal((OUTPUTS, len(FREQ)))
    drive = rng.standard_normal((2, len(FREQ)))
    u = np.zeros(samples)
    u[40:44] = 30, 90, 70, 20
    y = np.zeros((samples, OUTPUTS))
    for i, pole in enumerate(poles()):
        decay = np.exp(pole / RATE)
        x = signal.lfilter([0, 1], [1, -decay], u.astype(complex))
        y += np.real(np.outer(1j * x, shapes[:, i])) * drive[place, i]
    y += (
        noise
        * np.sqrt(np.mean(y**2, axis=0))
        * np.random.default_rng(seed).standard_normal(y.shape)
    )
    return u[:, None], y
