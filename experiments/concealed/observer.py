"""An extended Kalman filter around the integrator: the state of the true model before each sample.

Derivatives are central differences over one standard deviation, so that a kink inside what is
uncertain counts with the weight it has.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .integrator import WORK, across, observe, parts_of, starting_mode
from .laws import inner_limit
from .rig import System

Array = NDArray[np.float64]

SMALLEST = 1e-9


@njit(cache=True)
def _propagate(y, t, h, parts, forces, first, steps, work, system):  # type: ignore[no-untyped-def]
    mode = starting_mode(y, system)
    for s in range(steps):
        here, there = forces[first + s], forces[first + s + 1]
        mode = across(y, t + s * h, h, parts, here, there, work, system, mode)


@njit(cache=True)
def _filter(forces, steps, h, parts, measured, variance, T, Q, P, start, system):  # type: ignore[no-untyped-def]
    samples, channels = measured.shape
    n = len(system[0])
    size = len(start)
    floors = system[5].shape[0]
    work = np.zeros((WORK, size))
    x = start.copy()
    before = np.empty((samples, size))
    up, down, seen = np.empty(size), np.empty(size), np.empty(floors)
    H, F = np.empty((channels, size)), np.empty((size, size))
    other = np.empty(floors)
    for k in range(samples):
        before[k] = x
        t = k * steps * h
        pull = forces[k * steps]
        mode = starting_mode(x, system)
        for i in range(size):
            e = max(np.sqrt(max(P[i, i], 0.0)), SMALLEST)
            up[:] = x
            up[i] += e
            observe(seen, up, t, pull, system, mode, work[7])
            up[i] -= 2 * e
            observe(other, up, t, pull, system, mode, work[7])
            H[:, i] = T @ ((seen - other) / (2 * e))
        observe(seen, x, t, pull, system, mode, work[7])
        PH = P @ H.T
        gain = np.linalg.solve(H @ PH + np.diag(variance[k]), PH.T).T
        x = x + gain @ (measured[k] - T @ seen)
        P = P - gain @ PH.T
        if system[7] >= 0:
            for i in range(2 * n, size):
                most = inner_limit(system[3][system[7], 0], system[4][system[7]], i - 2 * n)
                x[i] = min(max(x[i], -most), most)
        if k == samples - 1:
            break
        for i in range(size):
            e = max(np.sqrt(max(P[i, i], 0.0)), SMALLEST)
            up[:] = x
            down[:] = x
            up[i] += e
            down[i] -= e
            _propagate(up, t, h, parts, forces, k * steps, steps, work, system)
            _propagate(down, t, h, parts, forces, k * steps, steps, work, system)
            F[:, i] = (up - down) / (2 * e)
        _propagate(x, t, h, parts, forces, k * steps, steps, work, system)
        P = F @ P @ F.T + Q
        P = 0.5 * (P + P.T)
    return before


def states_before(
    system: System,
    forces: Array,
    steps: int,
    step: float,
    measured: Array,
    variance: Array,
    seen_by: Array,
    process: Array,
    initial: Array,
) -> Array:
    """Return the state before each sample, from the samples before it, (samples, size).

    Args:
        system: the true model.
        forces: on the grid of ``step`` [N], (steps (samples - 1) + 1, floors or more).
        steps: of the grid in one sampling interval.
        step: of the grid [s].
        measured: accelerations [m/s^2], (samples, channels).
        variance: of each sample [m^2/s^4], the same shape.
        seen_by: what each channel sees of the floors' accelerations, (channels, floors).
        process: variance that one sampling interval adds to each state.
        initial: variance of each state at the start, which is rest.
    """
    start, parts = np.zeros(system.size), parts_of(system, step)
    before: Array = _filter(
        np.ascontiguousarray(forces), steps, step, parts, np.ascontiguousarray(measured),
        np.ascontiguousarray(variance), seen_by, np.diag(process), np.diag(initial), start,
        tuple(system),
    )  # fmt: skip
    return before
