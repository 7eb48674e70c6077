"""Runge and Kutta's fourth-order method for laws along any rows, dry friction by events.

The matrices are those of ``structure.py``. Forces are linear between the samples of the grid; a
grid step is cut into ``substeps``. Friction slides with a fixed sign until its drift rate vanishes;
that moment is found by bisection, and it then sticks or slides on as the force that would hold it
says.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..laws import BOUC_WEN, COULOMB, JENKINS, WIDTH, force, slider, slip_rate
from .structure import Array, Structure

BISECTIONS = 26


class System(NamedTuple):
    """What is integrated; every array in double precision.

    Attributes:
        inverse: of the mass matrix, (n, n).
        stiffness, damping: (n, n).
        pushes: rows of the inputs, (r, n).
        rows: of the laws, (laws, n).
        codes: of the laws, (laws,); at most one is dry friction.
        parameters: of the laws, (laws, ``WIDTH``).
        friction: which law is dry friction, -1 for none.
    """

    inverse: Array
    stiffness: Array
    damping: Array
    pushes: Array
    rows: Array
    codes: NDArray[np.int64]
    parameters: Array
    friction: int


def system_of(
    structure: Structure, pushes: list[Array], laws: list[tuple[int, list[float], Array]]
) -> System:
    """Return the system of a structure with inputs and laws (code, parameters, row)."""
    n = structure.size
    parameters = np.zeros((len(laws), WIDTH))
    for k, (_, values, _) in enumerate(laws):
        parameters[k, : len(values)] = values
    codes = np.array([code for code, _, _ in laws], np.int64)
    frictions = np.flatnonzero(codes == COULOMB)
    if len(frictions) > 1:
        raise ValueError("at most one law is dry friction")
    return System(
        np.linalg.inv(structure.mass),
        np.ascontiguousarray(structure.stiffness),
        np.ascontiguousarray(structure.damping),
        np.array(pushes, float).reshape(-1, n),
        np.array([row for _, _, row in laws], float).reshape(-1, n),
        codes,
        parameters,
        int(frictions[0]) if len(frictions) else -1,
    )


@njit(cache=True)
def _dot(row, y, first):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(len(row)):
        total += row[i] * y[first + i]
    return total


@njit(cache=True)
def _accelerate(a, f, y, t, u, system, mode, start):  # type: ignore[no-untyped-def]
    """Fill the accelerations; return dry friction's force (in stick, the one that holds)."""
    inverse, stiffness, damping, pushes, rows, codes, p, friction = system
    n = len(inverse)
    for i in range(n):
        total = 0.0
        for j in range(len(u)):
            total += pushes[j, i] * u[j]
        for j in range(n):
            total -= stiffness[i, j] * y[j] + damping[i, j] * y[n + j]
        f[i] = total
    for k in range(len(codes)):
        if k == friction:
            continue
        d, z = _dot(rows[k], y, 0), y[2 * n + k]
        if codes[k] == JENKINS:
            z = slider(p[k], d, _dot(rows[k], start, 0), start[2 * n + k])
        held = force(codes[k], p[k], d, _dot(rows[k], y, n), z, t)
        for i in range(n):
            f[i] -= rows[k, i] * held
    for i in range(n):
        a[i] = 0.0
        for j in range(n):
            a[i] += inverse[i, j] * f[j]
    if friction < 0:
        return 0.0
    row = rows[friction]
    if mode != 0:
        held = p[friction, 0] * mode
    else:
        lightness = 0.0
        for i in range(n):
            for j in range(n):
                lightness += row[i] * inverse[i, j] * row[j]
        held = _dot(row, a, 0) / lightness
    for i in range(n):
        for j in range(n):
            a[i] -= inverse[i, j] * row[j] * held
    return held


@njit(cache=True)
def _rate(rate, f, y, t, u, system, mode, start):  # type: ignore[no-untyped-def]
    n = len(system[0])
    _accelerate(rate[n : 2 * n], f, y, t, u, system, mode, start)
    for i in range(n):
        rate[i] = y[n + i]
    for k in range(len(system[5])):
        rate[2 * n + k] = 0.0
        if system[5][k] == BOUC_WEN:
            v = _dot(system[4][k], y, n)
            rate[2 * n + k] = slip_rate(BOUC_WEN, system[6][k], v, y[2 * n + k])


@njit(cache=True)
def _step(new, y, t, h, u0, u1, w, system, mode):  # type: ignore[no-untyped-def]
    n, size = len(system[0]), len(y)
    f = w[6, :n]
    um = 0.5 * (u0 + u1)
    _rate(w[0], f, y, t, u0, system, mode, y)
    for i in range(size):
        w[4, i] = y[i] + 0.5 * h * w[0, i]
    _rate(w[1], f, w[4], t + 0.5 * h, um, system, mode, y)
    for i in range(size):
        w[4, i] = y[i] + 0.5 * h * w[1, i]
    _rate(w[2], f, w[4], t + 0.5 * h, um, system, mode, y)
    for i in range(size):
        w[4, i] = y[i] + h * w[2, i]
    _rate(w[3], f, w[4], t + h, u1, system, mode, y)
    for i in range(size):
        new[i] = y[i] + h / 6 * (w[0, i] + 2 * w[1, i] + 2 * w[2, i] + w[3, i])
    for k in range(len(system[5])):
        if system[5][k] == JENKINS:
            new[2 * n + k] = slider(
                system[6][k], _dot(system[4][k], new, 0), _dot(system[4][k], y, 0), y[2 * n + k]
            )


@njit(cache=True)
def _holding(y, t, u, system, w):  # type: ignore[no-untyped-def]
    n = len(system[0])
    return _accelerate(w[5, :n], w[6, :n], y, t, u, system, 0, y)


@njit(cache=True)
def _gone(y, t, u, system, mode, w):  # type: ignore[no-untyped-def]
    """True when friction cannot go on: the slip has turned, or the stick is too weak."""
    n, friction = len(system[0]), system[7]
    if mode != 0:
        return mode * _dot(system[4][friction], y, n) < 0.0
    return abs(_holding(y, t, u, system, w)) > system[6][friction, 0]


@njit(cache=True)
def _stop(y, system):  # type: ignore[no-untyped-def]
    """Take out what is left of the drift rate along the row that sticks."""
    n, friction = len(system[0]), system[7]
    row = system[4][friction]
    size = 0.0
    for i in range(n):
        size += row[i] * row[i]
    v = _dot(row, y, n)
    for i in range(n):
        y[n + i] -= row[i] * v / size


@njit(cache=True)
def _advance(y, new, t, h, u0, u1, w, system, mode):  # type: ignore[no-untyped-def]
    if system[7] < 0:
        _step(new, y, t, h, u0, u1, w, system, mode)
        y[:] = new
        return mode
    done = 0.0
    for _ in range(8):
        begin = u0 + (u1 - u0) * (done / h)
        _step(new, y, t + done, h - done, begin, u1, w, system, mode)
        if not _gone(new, t + h, u1, system, mode, w):
            y[:] = new
            return mode
        low, high = 0.0, h - done
        for _ in range(BISECTIONS):
            tried = 0.5 * (low + high)
            end = u0 + (u1 - u0) * ((done + tried) / h)
            _step(new, y, t + done, tried, begin, end, w, system, mode)
            if _gone(new, t + done + tried, end, system, mode, w):
                high = tried
            else:
                low = tried
        end = u0 + (u1 - u0) * ((done + high) / h)
        _step(new, y, t + done, high, begin, end, w, system, mode)
        y[:] = new
        done += high
        _stop(y, system)
        held = _holding(y, t + done, end, system, w)
        stuck = mode != 0 and abs(held) <= system[6][system[7], 0]
        mode = 0 if stuck else (1 if held > 0 else -1)
        if done >= h:
            return mode
    begin = u0 + (u1 - u0) * (done / h)
    _step(new, y, t + done, h - done, begin, u1, w, system, mode)
    y[:] = new
    return mode


@njit(cache=True)
def _run(inputs, h, substeps, system):  # type: ignore[no-untyped-def]
    samples, n = len(inputs), len(system[0])
    size = 2 * n + len(system[5])
    w, y, new = np.zeros((7, size)), np.zeros(size), np.zeros(size)
    states, accelerations = np.empty((samples, size)), np.empty((samples, n))
    mode = 0
    for k in range(samples):
        t = k * h
        if k > 0:
            u0, u1 = inputs[k - 1], inputs[k]
            for part in range(substeps):
                a = u0 + (u1 - u0) * (part / substeps)
                b = u0 + (u1 - u0) * ((part + 1) / substeps)
                mode = _advance(
                    y, new, t - h + part * h / substeps, h / substeps, a, b, w, system, mode
                )
        if system[7] >= 0 and mode == 0 and _gone(y, t, inputs[k], system, 0, w):
            mode = 1 if _holding(y, t, inputs[k], system, w) > 0 else -1
        states[k] = y
        _accelerate(accelerations[k], w[6, :n], y, t, inputs[k], system, mode, y)
    return states, accelerations


def simulate(system: System, inputs: Array, step: float, substeps: int = 1) -> tuple[Array, Array]:
    """Integrate from rest.

    Args:
        system: what moves.
        inputs: (samples, r), one step apart, linear between.
        step: of the grid [s].
        substeps: of the method in one step of the grid.

    Returns:
        States (q, q', inner forces of the laws), (samples, 2 n + laws), and q'', (samples, n).
    """
    states, accelerations = _run(np.ascontiguousarray(inputs, float), step, substeps, system)
    return states, accelerations
