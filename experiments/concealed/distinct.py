"""Whether a soft base shows beyond what other masses, stiffnesses and damping would do.

A stiff base under the frame is, for all the recordings can tell, a softer first storey; such a
case would ask for what is not in the data, so the strength is drawn again.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from .plans import FINE_HZ, SAMPLING_HZ, Test, waveform
from .rig import Array, Integers, Rig, System, linear_system

Spectrum = NDArray[np.complex128]

HIGHEST_HZ = 100.0


def evidence(
    rig: Rig, system: System, tests: Sequence[Test], fine: bool, noise: float,
    recorded: Sequence[int] | None = None,
) -> float:  # fmt: skip
    """Return how much likelier the system is than the best frame without it [nats].

    Frequency by frequency, running steadily, on training recordings whose outputs carry white
    noise of that share of their RMS; every mass, stiffness and damping ratio is free. ``recorded``
    floors, from 1, have an accelerometer; None for all.
    """
    columns = np.array(recorded or range(1, rig.storeys + 1)) - 1
    spectra = [_spectrum(test, fine) for test in tests]
    targets, weights = [], []
    for test, (omega, force) in zip(tests, spectra, strict=True):
        target = _response(system, columns, test.floor - 1, omega) * force[:, None]
        scale = noise * np.sqrt(np.sum(np.abs(target) ** 2))
        targets.append(target)
        weights.append(np.sqrt(test.samples * len(columns)) / scale)

    def frame(change: Array) -> System:
        m, k, z = np.exp(change).reshape(3, -1)
        return linear_system(
            Rig(tuple(m * rig.masses), tuple(k * rig.stiffnesses), tuple(z * rig.damping_ratios))
        )

    def misfit(change: Array) -> Array:
        other = frame(change)
        parts = []
        for test, (omega, force), target, weight in zip(
            tests, spectra, targets, weights, strict=True
        ):
            seen = _response(other, columns, test.floor - 1, omega) * force[:, None]
            parts.append((weight * (seen - target)).ravel().view(float))
        return np.concatenate(parts)

    start = np.zeros(3 * rig.storeys)
    start[rig.storeys : 2 * rig.storeys] = _softened(rig, system)
    return float(least_squares(misfit, start, x_scale=0.01, max_nfev=30).cost)


def _spectrum(test: Test, fine: bool) -> tuple[Array, Spectrum]:
    """Return frequencies [rad/s] and the force's spectrum there."""
    force = waveform(test, fine)
    frequency = np.fft.rfftfreq(len(force), 1 / FINE_HZ)
    inside = (frequency > 0.3) & (frequency < min(HIGHEST_HZ, SAMPLING_HZ / 2))
    return np.asarray(2 * np.pi * frequency[inside], float), np.fft.rfft(force)[inside]


def _response(system: System, floors: Integers, driven: int, omega: Array) -> Spectrum:
    """Return the accelerations of some floors per force on one, (frequencies, floors)."""
    s = 1j * omega[:, None, None]
    dynamic = s**2 * np.diag(system.mass) + s * system.damping + system.stiffness
    unit = np.zeros((len(omega), len(system.mass), 1))
    unit[:, driven] = 1.0
    moved = np.linalg.solve(dynamic, unit)[:, floors, 0]
    return np.ascontiguousarray(-(omega[:, None] ** 2) * moved)


def _softened(rig: Rig, system: System) -> Array:
    """Return the logarithms by which the storeys' static stiffnesses differ from the rig's."""
    n = rig.storeys
    floors = np.linalg.inv(system.stiffness)[:n, :n]
    rows = rig.drifts @ floors @ rig.drifts.T
    return np.log(1 / (np.diag(rows) * np.array(rig.stiffnesses)))
