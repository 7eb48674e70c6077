"""The storey and floor laws, as numba functions of the integrator.

A law gives the force by which one part pulls its upper body back (and its lower body along): upper
and lower floor of a storey, or a floor and the fixed ground for the drag.
"""

from __future__ import annotations

import math

from numba import njit

from .near_laws import (
    DAHL,
    IWAN,
    LUGRE,
    SLIDERS,
    bristle,
    iwan_limit,
    iwan_slider,
    lugre_rate,
    near,
)

LINEAR, COULOMB, POLYNOMIAL, BUMPER, CLEARANCE, BOUC_WEN, JENKINS, DRAG, DRIFTING = range(9)
"""Codes of the laws; parameters stand in the order of ``force``'s docstring."""

TANH, SINE, EXPONENTIAL, MAGNET, BREATHING_GAP, MOVING_STOP, CROSS_AXIS = range(9, 16)
"""The same, of laws that no vocabulary names; those of ``near_laws`` come behind."""

WIDTH = 5
"""Places for the parameters of a law."""

CLOSEST = 0.03
"""The magnet's law ends at this share of its gap, where the poles would touch."""


@njit(cache=True)
def force(law, p, d, v, z, t):  # type: ignore[no-untyped-def]
    """Return the force [N] at drift ``d`` [m], drift rate ``v`` [m/s], inner state ``z``.

    POLYNOMIAL k2 d^2 + k3 d^3 (p = k2, k3); BUMPER k (d - gap) beyond the gap, whose sign is its
    side (gap, k); CLEARANCE minus the part ks within the play, nothing of it beyond (gap, ks);
    BOUC_WEN and JENKINS z - ks d (ks, yield force, exponent); DRAG c v|v| (c); DRIFTING
    k rate t d (k, rate). COULOMB is event-driven and stands in the integrator.

    TANH ks w tanh(d/w) and SINE ks w sin(d/w) (ks, w); EXPONENTIAL ks w (exp(d/w) - 1 - d/w)
    (ks, w); MAGNET -c ((1 - d/g)^-n - 1 - n d/g) (c, g, n); BREATHING_GAP and MOVING_STOP as
    clearance and bumper, their gap times 1 + a sin(2 pi t/T + phi) (gap, k, a, T, phi); CROSS_AXIS
    -2 c d z, with z the displacement of another axis [m] that c d^2 drives in turn (c).
    """
    if law == POLYNOMIAL:
        return p[0] * d * d + p[1] * d * d * d
    if law == BUMPER:
        if p[0] > 0:
            return p[1] * max(d - p[0], 0.0)
        return p[1] * min(d - p[0], 0.0)
    if law == CLEARANCE:
        return -p[1] * min(max(d, -p[0]), p[0])
    if law in (BOUC_WEN, JENKINS):
        return z - p[0] * d
    if law == DRAG:
        return p[0] * v * abs(v)
    if law == DRIFTING:
        return p[0] * p[1] * t * d
    return unnamed(law, p, d, v, z, t)


@njit(cache=True)
def unnamed(law, p, d, v, z, t):  # type: ignore[no-untyped-def]
    """Return the force [N] of the laws outside the vocabulary; see ``force``."""
    if law == TANH:
        return p[0] * p[1] * math.tanh(d / p[1])
    if law == SINE:
        return p[0] * p[1] * math.sin(d / p[1])
    if law == EXPONENTIAL:
        return p[0] * p[1] * (math.exp(min(d / p[1], 30.0)) - 1.0 - d / p[1])
    if law == MAGNET:
        share = d / p[1]
        return -p[0] * (math.pow(max(1.0 - share, CLOSEST), -p[2]) - 1.0 - p[2] * share)
    if law in (BREATHING_GAP, MOVING_STOP):
        gap = p[0] * (1.0 + p[2] * math.sin(2 * math.pi * t / p[3] + p[4]))
        if law == BREATHING_GAP:
            return -p[1] * min(max(d, -gap), gap)
        return p[1] * (max(d - gap, 0.0) if p[0] > 0 else min(d - gap, 0.0))
    if law == CROSS_AXIS:
        return -2 * p[0] * d * z
    return near(law, p, d, v, z)


@njit(cache=True)
def slip_rate(law, p, v, z):  # type: ignore[no-untyped-def]
    """Return dz/dt of the bristles of LuGre [m/s], or of Bouc and Wen [N/s].

    The latter: ks v (1 - |z/zy|^n (1 + sign(v z))/2).
    """
    if law == LUGRE:
        return lugre_rate(p, v, z)
    if law != BOUC_WEN or v == 0.0:
        return 0.0
    if v * z <= 0.0:
        return p[0] * v
    return p[0] * v * (1.0 - math.pow(abs(z) / p[1], p[2]))


@njit(cache=True)
def slider(p, d, d0, z0):  # type: ignore[no-untyped-def]
    """Return Jenkins' inner force [N] after a monotone move from drift d0, inner force z0, to d."""
    return min(max(z0 + p[0] * (d - d0), -p[1]), p[1])


@njit(cache=True)
def inner(law, p, d, d0, y, before, first):  # type: ignore[no-untyped-def]
    """Return the inner state that a law's force takes at drift ``d``, summed over its sliders.

    Where its way is known (sliders, Dahl's bristles) that is exact for a monotone move from drift
    ``d0`` and the state ``before``; else it is part of the state ``y``, at ``first``.
    """
    if law == JENKINS:
        return slider(p, d, d0, before[first])
    if law == DAHL:
        return bristle(p, d, d0, before[first])
    if law == IWAN:
        total = 0.0
        for i in range(SLIDERS):
            total += iwan_slider(p, i, d, d0, before[first + i])
        return total
    return y[first]


@njit(cache=True)
def settle(law, p, d, d0, y, before, first):  # type: ignore[no-untyped-def]
    """Set the inner state at the end of a step, where its way is known; see ``inner``."""
    if law in (JENKINS, DAHL):
        y[first] = inner(law, p, d, d0, y, before, first)
    elif law == IWAN:
        for i in range(SLIDERS):
            y[first + i] = iwan_slider(p, i, d, d0, before[first + i])


@njit(cache=True)
def inner_limit(law, p, i):  # type: ignore[no-untyped-def]
    """Return how far the i-th inner state of a law can go, from 0."""
    if law == IWAN:
        return iwan_limit(p, i)
    if law == LUGRE:
        return p[3] / p[0]
    return p[1]
