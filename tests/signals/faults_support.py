"""Recordings of random structures: a force, two accelerations, white noise."""

import numpy as np
from scipy import signal

RATE = 256.0
SAMPLES = 4096


def structure(seed, low=1.5, high=9.0, samples=SAMPLES, noise=0.01, rate=RATE):
    """Force, two accelerations (samples, 2), the standard deviations of their noise.

    Two to four modes between ``low`` and ``high`` Hz, damped by 0.3 to 3 %, struck once or more or
    shaken; the first acceleration is at the force.
    """
    draw = np.random.default_rng(seed)
    modes = draw.integers(2, 5)
    omega = 2 * np.pi * np.sort(draw.uniform(low, high, modes)) / rate
    zeta = 10 ** draw.uniform(-2.5, -1.5, modes)
    shapes = draw.uniform(-1, 1, (2, modes))
    force = np.zeros(samples)
    if seed % 2:
        for start in draw.integers(60, samples // 2, draw.integers(1, 4)):
            force[start : start + 6] += 10 * draw.uniform(0.5, 2) * np.hanning(8)[1:-1]
    else:
        band = signal.butter(4, [0.3, min(2 * high, 0.4 * rate)], "bandpass", fs=rate, output="sos")
        force = signal.sosfilt(band, draw.standard_normal(samples))
    motion = np.zeros((samples, 2))
    for w, z, shape in zip(omega, zeta, shapes.T, strict=True):
        A = np.array([[0, 1], [-(w**2), -2 * z * w]])
        b, a = signal.ss2tf(
            *signal.cont2discrete((A, np.eye(2)[:, 1:], A[1:], np.eye(1)), 1.0, "foh")[:4]
        )
        motion += signal.lfilter(b[0], a, force)[:, None] * shape * shape[0]
    level = noise * motion.std(axis=0)
    noisy = motion + level * draw.standard_normal(motion.shape)
    return force + 1e-3 * force.std() * draw.standard_normal(samples), noisy, level
