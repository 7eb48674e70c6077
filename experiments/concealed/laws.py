"""The storey and floor laws, as numba functions of the integrator.

A law gives the force by which one part pulls its upper body back (and its lower body along): upper
and lower floor of a storey, or a floor and the fixed ground for the drag.
"""

from __future__ import annotations

import math

from numba import njit

LINEAR, COULOMB, POLYNOMIAL, BUMPER, CLEARANCE, BOUC_WEN, JENKINS, DRAG, DRIFTING = range(9)
"""Codes of the laws; parameters stand in the order of ``force``'s docstring."""


@njit(cache=True)
def force(law, p, d, v, z, t):  # type: ignore[no-untyped-def]
    """Return the force [N] at drift ``d`` [m], drift rate ``v`` [m/s], inner force ``z`` [N].

    POLYNOMIAL k2 d^2 + k3 d^3 (p = k2, k3); BUMPER k (d - gap) beyond the gap, whose sign is its
    side (gap, k); CLEARANCE minus the part ks within the play, nothing of it beyond (gap, ks);
    BOUC_WEN and JENKINS z - ks d (ks, yield force, exponent); DRAG c v|v| (c); DRIFTING
    k rate t d (k, rate). COULOMB is event-driven and stands in the integrator.
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
    return 0.0


@njit(cache=True)
def slip_rate(law, p, v, z):  # type: ignore[no-untyped-def]
    """Return dz/dt [N/s] of Bouc and Wen: ks v (1 - |z/zy|^n (1 + sign(v z))/2)."""
    if law != BOUC_WEN or v == 0.0:
        return 0.0
    if v * z <= 0.0:
        return p[0] * v
    return p[0] * v * (1.0 - math.pow(abs(z) / p[1], p[2]))


@njit(cache=True)
def slider(p, d, d0, z0):  # type: ignore[no-untyped-def]
    """Return Jenkins' inner force [N] after a monotone move from drift d0, inner force z0, to d."""
    return min(max(z0 + p[0] * (d - d0), -p[1]), p[1])
