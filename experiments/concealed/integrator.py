"""Runge and Kutta's fourth-order method at a fixed small step, dry friction by events.

Friction slides with a fixed sign until the drift rate vanishes; that moment is found within the
step, and the storey then sticks, or slides the other way, as the force that would hold it says.
Forces are linear between the samples of the step's grid. Laws that relax faster than the grid
follows get equal parts of its steps.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .laws import COULOMB, CROSS_AXIS, force, inner, settle, slip_rate
from .near_laws import STRIBECK, falling
from .rig import System

Array = NDArray[np.float64]

BISECTIONS = 26
"""An event is found within a step over two to this power, 4e-12 s."""

REACH = 0.5
"""A step is at most this share of the time in which the system's fastest law relaxes."""

WORK = 12
"""Vectors of the state's size that ``across`` needs."""


@njit(cache=True, inline="always")
def _drift(y, system, law, first=0):  # type: ignore[no-untyped-def]
    """Return a law's drift, or with ``first`` the number of degrees of freedom its rate."""
    top, bottom = system[3][law, 1], system[3][law, 2]
    return y[first + top] - y[first + bottom] if bottom >= 0 else y[first + top]


@njit(cache=True, inline="always")
def _pull(a, held, system, law):  # type: ignore[no-untyped-def]
    """Take a law's force off what moves its two bodies."""
    mass, top, bottom = system[0], system[3][law, 1], system[3][law, 2]
    a[top] -= held / mass[top]
    if bottom >= 0:
        a[bottom] += held / mass[bottom]


@njit(cache=True)
def _accelerate(a, y, t, pull, system, mode, before):  # type: ignore[no-untyped-def]
    """Fill the accelerations; return dry friction's force (in stick, the one that holds).

    ``before`` is the state at the start of the step, from where inner forces have moved.
    """
    mass, stiffness, damping, laws, p, _, friction, slip, aside, _, _ = system
    n = len(mass)
    for i in range(n):
        total = pull[i] if i < len(pull) else 0.0
        for j in range(n):
            total -= stiffness[i, j] * y[j] + damping[i, j] * y[n + j]
        a[i] = total / mass[i]
    for k in range(len(laws)):
        if laws[k, 0] == COULOMB or laws[k, 0] == STRIBECK:
            continue
        d = _drift(y, system, k)
        z = 0.0
        if k == slip:
            z = inner(laws[k, 0], p[k], d, _drift(before, system, k), y, before, 2 * n)
        elif laws[k, 0] == CROSS_AXIS:
            z = y[aside]
            a[aside] += p[k, 0] * d * d / mass[aside]
        _pull(a, force(laws[k, 0], p[k], d, _drift(y, system, k, n), z, t), system, k)
    if friction < 0:
        return 0.0
    if mode != 0:
        held = p[friction, 0] * mode
        if laws[friction, 0] == STRIBECK:
            held = falling(p[friction], _drift(y, system, friction, n)) * mode
    else:
        top, bottom = laws[friction, 1], laws[friction, 2]
        relative, inverse = a[top], 1 / mass[top]
        if bottom >= 0:
            relative -= a[bottom]
            inverse += 1 / mass[bottom]
        held = relative / inverse
    _pull(a, held, system, friction)
    return held


@njit(cache=True)
def _rate(rate, y, t, pull, system, mode, before):  # type: ignore[no-untyped-def]
    n, slip = len(system[0]), system[7]
    _accelerate(rate[n : 2 * n], y, t, pull, system, mode, before)
    for i in range(n):
        rate[i] = y[n + i]
    for i in range(2 * n, len(rate)):
        rate[i] = 0.0
    if slip >= 0:
        v = _drift(y, system, slip, n)
        rate[2 * n] = slip_rate(system[3][slip, 0], system[4][slip], v, y[2 * n])


@njit(cache=True)
def _step(new, y, t, h, start, end, work, system, mode):  # type: ignore[no-untyped-def]
    """One step from ``y`` to ``new``; the force goes linearly from ``start`` to ``end``."""
    k1, k2, k3, k4, at, middle = work[0], work[1], work[2], work[3], work[4], work[5]
    size = len(y)
    floors = len(start)
    pull = middle[:floors]
    slip = system[7]
    _rate(k1, y, t, start, system, mode, y)
    for i in range(floors):
        pull[i] = 0.5 * (start[i] + end[i])
    for i in range(size):
        at[i] = y[i] + 0.5 * h * k1[i]
    _rate(k2, at, t + 0.5 * h, pull, system, mode, y)
    for i in range(size):
        at[i] = y[i] + 0.5 * h * k2[i]
    _rate(k3, at, t + 0.5 * h, pull, system, mode, y)
    for i in range(size):
        at[i] = y[i] + h * k3[i]
    _rate(k4, at, t + h, end, system, mode, y)
    for i in range(size):
        new[i] = y[i] + h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])
    if slip >= 0:
        d, d0 = _drift(new, system, slip), _drift(y, system, slip)
        settle(system[3][slip, 0], system[4][slip], d, d0, new, y, 2 * len(system[0]))


@njit(cache=True)
def _gone(y, t, pull, system, mode, spare):  # type: ignore[no-untyped-def]
    """True when friction cannot go on as it does: the slip has turned, or the stick is too weak."""
    n = len(system[0])
    if mode != 0:
        return mode * _drift(y, system, system[6], n) < 0.0
    return abs(_holding(y, t, pull, system, spare)) > system[4][system[6], 0]


@njit(cache=True)
def _holding(y, t, pull, system, spare):  # type: ignore[no-untyped-def]
    """Return the friction force that would keep the storey from slipping [N]."""
    return _accelerate(spare[: len(system[0])], y, t, pull, system, 0, y)


@njit(cache=True)
def _stop(y, system):  # type: ignore[no-untyped-def]
    """Take the last trace of drift rate away, keeping the momentum."""
    mass, laws, friction = system[0], system[3], system[6]
    top, bottom = laws[friction, 1], laws[friction, 2]
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
    friction = system[6]
    if friction < 0:
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
        held = _holding(y, t + done, to, system, work[7])
        stuck = mode != 0 and abs(held) <= system[4][friction, 0]
        mode = 0 if stuck else (1 if held > 0 else -1)
        if done >= h:
            return mode
    for i in range(floors):
        from_[i] = start[i] + (end[i] - start[i]) * done / h
    _step(new, y, t + done, h - done, from_, end, work[:6], system, mode)
    for i in range(size):
        y[i] = new[i]
    return mode


@njit(cache=True)
def across(y, t, h, parts, start, end, work, system, mode):  # type: ignore[no-untyped-def]
    """Advance ``y`` in place by one step of the grid in equal parts; return friction's mode."""
    if parts == 1:
        return advance(y, t, h, start, end, work, system, mode)
    floors, part = len(start), h / parts
    here, there = work[10][:floors], work[11][:floors]
    for k in range(parts):
        for i in range(floors):
            here[i] = start[i] + (end[i] - start[i]) * k / parts
            there[i] = start[i] + (end[i] - start[i]) * (k + 1) / parts
        mode = advance(y, t + k * part, part, here, there, work, system, mode)
    return mode


@njit(cache=True)
def observe(out, y, t, pull, system, mode, spare):  # type: ignore[no-untyped-def]
    """Fill what the accelerometers see [m/s^2]: the floors' accelerations and ``seen``."""
    n = len(system[0])
    _accelerate(spare[:n], y, t, pull, system, mode, y)
    for i in range(len(out)):
        out[i] = spare[i]
        for j in range(n):
            out[i] += system[5][i, j] * y[j]


@njit(cache=True)
def starting_mode(y, system):  # type: ignore[no-untyped-def]
    """Return friction's mode that belongs to a state: the sign of the drift rate."""
    if system[6] < 0:
        return 0
    v = _drift(y, system, system[6], len(system[0]))
    return (v > 0) - (v < 0)


@njit(cache=True)
def _run(start, forces, h, t0, parts, system):  # type: ignore[no-untyped-def]
    samples, floors, size = len(forces), len(system[5]), len(start)
    work = np.zeros((WORK, size))
    y = start.copy()
    mode = starting_mode(y, system)
    seen, states = np.empty((samples, floors)), np.empty((samples, size))
    for k in range(samples):
        t = t0 + k * h
        if k > 0:
            mode = across(y, t - h, h, parts, forces[k - 1], forces[k], work, system, mode)
        if system[6] >= 0 and mode == 0 and _gone(y, t, forces[k], system, 0, work[7]):
            mode = 1 if _holding(y, t, forces[k], system, work[7]) > 0 else -1
        states[k] = y
        observe(seen[k], y, t, forces[k], system, mode, work[7])
    return seen, states


def simulate(
    system: System, forces: Array, step: float, start: Array | None = None, t0: float = 0.0
) -> tuple[Array, Array]:
    """Integrate the system.

    Args:
        system: what moves.
        forces: on the floors [N], (samples, floors), one step apart, linear between; or on all
            degrees of freedom.
        step: of the grid [s].
        start: displacements [m], velocities [m/s] and what the slipping law keeps; None for rest.
        t0: time of the first sample [s].

    Returns:
        What the accelerometers see [m/s^2], (samples, floors), and the states, (samples, size).
    """
    y = np.zeros(system.size) if start is None else np.array(start, float)
    parts = parts_of(system, step)
    seen, states = _run(y, np.ascontiguousarray(forces, float), step, t0, parts, tuple(system))
    return seen, states


def parts_of(system: System, step: float) -> int:
    """Return into how many parts a step [s] is cut for the system's fastest law."""
    return max(1, math.ceil(step * system.fastest / REACH))
