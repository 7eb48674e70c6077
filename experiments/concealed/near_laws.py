"""Laws that are nearly, but not quite, in the vocabulary, as numba functions of the integrator.

Friction of Stribeck (falls with speed), Dahl and LuGre (bristles) and a tanh; a contact of Hunt and
Crossley (damped) and of Hertz (power 3/2); a power spring; Iwan's sliders in parallel.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from numba import njit

STRIBECK, SMOOTH, DAHL, LUGRE, HUNT_CROSSLEY, HERTZ, POWER, IWAN = range(16, 24)
"""Codes of the laws; parameters stand in the order of ``near``'s docstring."""

SLIDERS = 12
"""Jenkins elements of an Iwan law, each with an inner force of its own."""

SWIFTEST_M_S = 0.1
"""Drift rate up to which LuGre's bristles, which turn over at |v| over their deflection, are
followed closely; up to five times as much they are at their limit, and the integration stable."""


@njit(cache=True)
def near(law, p, d, v, z):  # type: ignore[no-untyped-def]
    """Return the force [N] at drift ``d`` [m], drift rate ``v`` [m/s], inner state ``z``.

    SMOOTH F tanh(v/w) (F, w); DAHL z (bristles' stiffness, F); LUGRE s0 z + s1 dz/dt
    (s0, s1, F, breakaway Fs, Stribeck's velocity; its z is a deflection [m]); HUNT_CROSSLEY
    k x (1 + c dx/dt) and HERTZ k x^(3/2) at the depth x beyond a gap whose sign is its side
    (gap, k, c); POWER k |d|^n d (k, n); IWAN z - ks d (ks, yield force, exponent a; z the sum of
    the sliders, each of stiffness ks/N, the i-th of which yields at a share that goes as
    ((i - 1/2)/N)^a). STRIBECK is event-driven and stands in the integrator.
    """
    if law == SMOOTH:
        return p[0] * math.tanh(v / p[1])
    if law == DAHL:
        return z
    if law == LUGRE:
        return p[0] * z + p[1] * lugre_rate(p, v, z)
    if law == POWER:
        return p[0] * math.pow(abs(d), p[1]) * d
    if law == IWAN:
        return z - p[0] * d
    side = 1.0 if p[0] > 0 else -1.0
    depth = side * (d - p[0])
    if depth <= 0.0:
        return 0.0
    if law == HERTZ:
        return side * p[1] * depth * math.sqrt(depth)
    if law == HUNT_CROSSLEY:  # a contact does not pull
        return side * p[1] * depth * max(1.0 + p[2] * side * v, 0.0)
    return 0.0


@njit(cache=True)
def lugre_rate(p, v, z):  # type: ignore[no-untyped-def]
    """Return dz/dt [m/s] of the bristles: v - s0 |v| z / g(v)."""
    steady = p[2] + (p[3] - p[2]) * math.exp(-((v / p[4]) ** 2))
    return v - p[0] * abs(v) * z / steady


@njit(cache=True)
def falling(p, v):  # type: ignore[no-untyped-def]
    """Return Stribeck's friction [N] at a sliding speed: from breakaway p0 down to p1 over p2."""
    return p[1] + (p[0] - p[1]) * math.exp(-((v / p[2]) ** 2))


@njit(cache=True)
def bristle(p, d, d0, z0):  # type: ignore[no-untyped-def]
    """Return Dahl's force [N] after a monotone move from drift d0, force z0, to d: exact."""
    end = p[1] if d > d0 else -p[1]
    return end + (z0 - end) * math.exp(-p[0] * abs(d - d0) / p[1])


@njit(cache=True)
def iwan_limit(p, i):  # type: ignore[no-untyped-def]
    """Return the force [N] at which the i-th slider of an Iwan law yields, from 0."""
    total = 0.0
    for j in range(SLIDERS):
        total += math.pow((j + 0.5) / SLIDERS, p[2])
    return p[1] * math.pow((i + 0.5) / SLIDERS, p[2]) / total


@njit(cache=True)
def iwan_slider(p, i, d, d0, z0):  # type: ignore[no-untyped-def]
    """Return the i-th slider's force [N] after a monotone move from drift d0, force z0, to d."""
    limit = iwan_limit(p, i)
    return min(max(z0 + p[0] / SLIDERS * (d - d0), -limit), limit)


def fastest_of(code: int, parameters: Sequence[float], inverse_mass: float) -> float:
    """Return the fastest rate [1/s] at which a law relaxes; 0 where the frame's own are faster.

    Args:
        code: of the law.
        parameters: in the order of ``near``.
        inverse_mass: sum of 1/m over the bodies that it acts between [1/kg].
    """
    if code == SMOOTH:
        return parameters[0] / parameters[1] * inverse_mass
    if code == LUGRE:
        stiffness, damping, friction = parameters[:3]
        return SWIFTEST_M_S * stiffness / friction + damping * inverse_mass
    return 0.0
