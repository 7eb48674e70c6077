"""Runge and Kutta's fourth-order method at a fixed small step, dry friction by events.

Friction slides with a fixed sign until the drift rate vanishes; that moment is found within the
step, and the storey then sticks, or slides the other way, as the force that would hold it says.
Forces are linear between the samples of the step's grid.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .laws import COULOMB, JENKINS, force, slider, slip_rate
from .rig import System

Array = NDArray[np.float64]

BISECTIONS = 26
"""An event is found within a step over two to this power, 4e-12 s."""


@njit(cache=True)
def _drift(y, top, bottom, first=0):  # type: ignore[no-untyped-def]
    """Return the drift, or with ``first`` the number of degrees of freedom its rate."""
    return y[first + top] - y[first + bottom] if bottom >= 0 else y[first + top]


@njit(cache=True)
def _accelerate(a, y, t, pull, system, mode, d0, z0):  # type: ignore[no-untyped-def]
    """Fill the accelerations; return the law's force (in stick, the one that holds)."""
    mass, stiffness, damping, law, p, top, bottom, _ = system
    n = len(mass)
    for i in range(n):
        total = pull[i] if i < len(pull) else 0.0
        for j in range(n):
            total -= stiffness[i, j] * y[j] + damping[i, j] * y[n + j]
        a[i] = total / mass[i]
    if law == 0:
        return 0.0
    if law == COULOMB:
        if mode != 0:
            held = p[0] * mode
        else:
            relative, inverse = a[top], 1 / mass[top]
            if bottom >= 0:
                relative -= a[bottom]
                inverse += 1 / mass[bottom]
            held = relative / inverse
    else:
        d = _drift(y, top, bottom)
        v = _drift(y, top, bottom, n)
        z = slider(p, d, d0, z0) if law == JENKINS else y[2 * n]
        held = force(law, p, d, v, z, t)
    a[top] -= held / mass[top]
    if bottom >= 0:
        a[bottom] += held / mass[bottom]
    return held


@njit(cache=True)
def _rate(rate, y, t, pull, system, mode, d0, z0):  # type: ignore[no-untyped-def]
    n = len(system[0])
    _accelerate(rate[n : 2 * n], y, t, pull, system, mode, d0, z0)
    for i in range(n):
        rate[i] = y[n + i]
    rate[2 * n] = slip_rate(system[3], system[4], _drift(y, system[5], system[6], n), y[2 * n])


@njit(cache=True)
def _step(new, y, t, h, start, end, work, system, mode):  # type: ignore[no-untyped-def]
    """One step from ``y`` to ``new``; the force goes linearly from ``start`` to ``end``."""
    k1, k2, k3, k4, at, middle = work[0], work[1], work[2], work[3], work[4], work[5]
    size = len(y)
    floors = len(start)
    pull = middle[:floors]
    d0, z0 = _drift(y, system[5], system[6]), y[size - 1]
    _rate(k1, y, t, start, system, mode, d0, z0)
    for i in range(floors):
        pull[i] = 0.5 * (start[i] + end[i])
    for i in range(size):
        at[i] = y[i] + 0.5 * h * k1[i]
    _rate(k2, at, t + 0.5 * h, pull, system, mode, d0, z0)
    for i in range(size):
        at[i] = y[i] + 0.5 * h * k2[i]
    _rate(k3, at, t + 0.5 * h, pull, system, mode, d0, z0)
    for i in range(size):
        at[i] = y[i] + h * k3[i]
    _rate(k4, at, t + h, end, system, mode, d0, z0)
    for i in range(size):
        new[i] = y[i] + h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])
    if system[3] == JENKINS:
        new[size - 1] = slider(system[4], _drift(new, system[5], system[6]), d0, z0)


@njit(cache=True)
def _gone(y, t, pull, system, mode, spare):  # type: ignore[no-untyped-def]
    """True when friction cannot go on as it does: the slip has turned, or the stick is too weak."""
    n = len(system[0])
    if mode != 0:
        return mode * _drift(y, system[5], system[6], n) < 0.0
    held = _accelerate(spare[:n], y, t, pull, system, 0, 0.0, 0.0)
    return abs(held) > system[4][0]


@njit(cache=True)
def _stop(y, system):  # type: ignore[no-untyped-def]
    """Take the last trace of drift rate away, keeping the momentum."""
    mass, top, bottom = system[0], system[5], system[6]
    n = len(mass)
    if bottom < 0:
        y[n + top] = 0.0
        return
    together = mass[top] + mass[bottom]
    v = (mass[top] * y[n + top] + mass[bottom] * y[n + bottom]) / together
    y[n + top] = v
    y[n + bottom] = v


@njit(cache=True)
def advance(y, t, h, start, end, work, system, mode):  # type: ignore[no-untyped-def]
    """Advance ``y`` in place by one step of the grid; return friction's mode after it."""
    size = len(y)
    new, last, left = work[6], work[8], work[9]
    if system[3] != COULOMB:
        _step(new, y, t, h, start, end, work[:6], system, mode)
        y[:] = new
        return mode
    floors = len(start)
    from_, to = left[:floors], last[:floors]
    done = 0.0
    for _ in range(8):
        rest = h - done
        for i in range(floors):
            from_[i] = start[i] + (end[i] - start[i]) * done / h
        _step(new, y, t + done, rest, from_, end, work[:6], system, mode)
        if not _gone(new, t + h, end, system, mode, work[7]):
            y[:] = new
            return mode
        low, high = 0.0, rest
        for _ in range(BISECTIONS):
            tried = 0.5 * (low + high)
            for i in range(floors):
                to[i] = start[i] + (end[i] - start[i]) * (done + tried) / h
            _step(new, y, t + done, tried, from_, to, work[:6], system, mode)
            if _gone(new, t + done + tried, to, system, mode, work[7]):
                high = tried
            else:
                low = tried
        for i in range(floors):
            to[i] = start[i] + (end[i] - start[i]) * (done + high) / h
        _step(new, y, t + done, high, from_, to, work[:6], system, mode)
        y[:] = new
        done += high
        _stop(y, system)
        held = _accelerate(work[7][: len(system[0])], y, t + done, to, system, 0, 0.0, 0.0)
        mode = 0 if mode != 0 and abs(held) <= system[4][0] else (1 if held > 0 else -1)
        if done >= h:
            return mode
    for i in range(floors):
        from_[i] = start[i] + (end[i] - start[i]) * done / h
    _step(new, y, t + done, h - done, from_, end, work[:6], system, mode)
    for i in range(size):
        y[i] = new[i]
    return mode


@njit(cache=True)
def observe(out, y, t, pull, system, mode, spare):  # type: ignore[no-untyped-def]
    """Fill what the accelerometers see [m/s^2]: the floors' accelerations and ``seen``."""
    n = len(system[0])
    _accelerate(spare[:n], y, t, pull, system, mode, _drift(y, system[5], system[6]), y[2 * n])
    for i in range(len(out)):
        out[i] = spare[i]
        for j in range(n):
            out[i] += system[7][i, j] * y[j]


@njit(cache=True)
def starting_mode(y, system):  # type: ignore[no-untyped-def]
    """Return friction's mode that belongs to a state: the sign of the drift rate."""
    v = _drift(y, system[5], system[6], len(system[0]))
    return (v > 0) - (v < 0)


@njit(cache=True)
def _run(start, forces, h, t0, system):  # type: ignore[no-untyped-def]
    samples, floors = forces.shape
    n = len(system[0])
    work = np.zeros((10, 2 * n + 1))
    y = start.copy()
    mode = starting_mode(y, system)
    seen, states = np.empty((samples, floors)), np.empty((samples, 2 * n + 1))
    for k in range(samples):
        t = t0 + k * h
        if k > 0:
            mode = advance(y, t - h, h, forces[k - 1], forces[k], work, system, mode)
        if system[3] == COULOMB and mode == 0 and _gone(y, t, forces[k], system, 0, work[7]):
            held = _accelerate(work[7][:n], y, t, forces[k], system, 0, 0.0, 0.0)
            mode = 1 if held > 0 else -1
        states[k] = y
        observe(seen[k], y, t, forces[k], system, mode, work[7])
    return seen, states


def simulate(
    system: System, forces: Array, step: float, start: Array | None = None, t0: float = 0.0
) -> tuple[Array, Array]:
    """Integrate the system.

    Args:
        system: what moves.
        forces: on the floors [N], (samples, floors), one step apart, linear between.
        step: of the grid [s].
        start: displacements [m], velocities [m/s] and the inner force [N]; None for rest.
        t0: time of the first sample [s].

    Returns:
        What the accelerometers see [m/s^2], (samples, floors), and the states, (samples, 2 n + 1).
    """
    y = np.zeros(2 * len(system.mass) + 1) if start is None else np.array(start, float)
    seen, states = _run(y, np.ascontiguousarray(forces, float), step, t0, tuple(system))
    return seen, states


def drift(system: System, states: Array) -> Array:
    """Return the drift that the system's law sees [m]."""
    upper = states[:, system.top]
    return upper - states[:, system.bottom] if system.bottom >= 0 else upper
