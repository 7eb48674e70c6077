"""How much of a missing force the nearest law of the vocabulary accounts for at best.

The force f(t) that acted at the port is what is left of the equations of motion as the integrator
solved them. Its nearest law g has the least sum of (f - g)^2 over the law's parameters, on the true
motion. Then, explained = 1 - RMS(f - g) / RMS(f). All four laws may be scaled, so that f - g is
orthogonal to g and RMS(f)^2 = RMS(f - g)^2 + RMS(g)^2: it is the share that a diagnosis states, one
less the discrepancy's RMS over the hypotenuse of it and the law's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.optimize import minimize, minimize_scalar

from .mechanisms import NEAREST, Mechanism, build
from .motions import loads
from .plans import Test
from .rig import Array, Rig

REST = 0.01
"""A drift rate below this share of its RMS, the noise of a good recording, is rest to whoever
measured it; at rest dry friction is whatever holds, up to its force."""

EVERY = 4
"""Steps of the integrator between two samples that are looked at."""

GRID = 40
SHARPNESSES, SHAPES = (1.0, 2.0, 4.0), (0.5, 0.0)


@dataclass(frozen=True)
class Port:
    """What moved and acted at a storey, recording after recording.

    Attributes:
        force: by which the concealed law pulled the upper floor back [N].
        drift: [m].
        rate: of the drift [m/s].
        begins: True at a recording's first sample.
    """

    force: Array
    drift: Array
    rate: Array
    begins: Array


def port_of(
    rig: Rig, effect: Mechanism, tests: Sequence[Test], runs: Sequence[tuple[Array, Array, Array]]
) -> Port:
    """Return what acted at the storey of the one effect.

    Args:
        rig: as built.
        effect: what is concealed.
        tests: the recordings.
        runs: ``motions.motion`` of each.
    """
    i, n = effect.index, rig.storeys
    system = build(rig, effect)
    forces, drifts, rates, begins = [], [], [], []
    for test, (drive, seen, states) in zip(tests, runs, strict=True):
        q, v = states[:, :n], states[:, n : 2 * n]
        ground = drive[:, None] if test.floor == 0 else 0.0
        left = loads(system, test, drive) - (seen - ground) * system.mass
        left -= q @ system.stiffness.T + v @ system.damping.T
        forces.append(left[::EVERY, i])
        drifts.append((q @ rig.drifts[i])[::EVERY])
        rates.append((v @ rig.drifts[i])[::EVERY])
        begins.append(np.arange(len(forces[-1])) == 0)
    return Port(*map(np.concatenate, (forces, drifts, rates, begins)))


def explained_share(effect: Mechanism, port: Port) -> float:
    """Return the share of the missing force that the nearest law explains; see the module."""
    left = _LEFT[NEAREST[effect.name]](port)
    return float(1 - np.sqrt(left / np.sum(port.force**2)))


def of_friction(port: Port) -> float:
    """Return the least sum of squares that dry friction leaves [N^2]."""
    rest = REST * np.sqrt(np.mean(port.rate**2))
    f, slips = port.force, np.abs(port.rate) > rest
    sign, held = np.sign(port.rate[slips]), np.abs(f[~slips])

    def left(level: float) -> float:
        beyond = np.maximum(held - level, 0.0)
        return float(np.sum((f[slips] - level * sign) ** 2) + np.sum(beyond**2))

    bounds = (0.0, float(np.abs(f).max()))
    return float(minimize_scalar(left, bounds=bounds, method="bounded").fun)


def of_bumper(port: Port) -> float:
    """Return the least sum of squares that a linear bumper on either side leaves [N^2]."""
    return min(_of_stop(port.force, port.drift), _of_stop(-port.force, -port.drift))


def _of_stop(f: Array, d: Array) -> float:
    top = float(d.max())
    if top <= 0:
        return float(np.sum(f**2))
    return _best(lambda gap: _left(f, np.maximum(d - gap, 0.0)), np.linspace(0, top, GRID + 1)[:-1])


def of_cubic(port: Port) -> float:
    """Return the sum of squares that a cubic spring leaves [N^2]."""
    return _left(port.force, port.drift**3)


def of_loop(port: Port) -> float:
    """Return the least sum of squares that a hysteresis of Bouc and Wen leaves [N^2].

    z' = ks v (1 - |z/zy|^n (shape + sign(v z)/2)), f = z - k d: by ks, k, zy, n and the shape.
    """
    f, d, scale = port.force, port.drift, float(np.abs(port.drift).max())

    def left(given: Array) -> float:
        slip, sharpness = np.exp(given[:2])
        z = loop(d, port.begins, scale * slip, sharpness, given[2])
        return _left(f, np.column_stack([z, d]))

    starts = [np.array([np.log(s), np.log(n), shape]) for s in np.geomspace(0.02, 1.0, 7)
              for n in SHARPNESSES for shape in SHAPES]  # fmt: skip
    best = min(starts, key=left)
    return float(minimize(left, best, method="Nelder-Mead", options={"maxfev": 200}).fun)


@njit(cache=True)
def loop(d, begins, yielding, sharpness, shape):  # type: ignore[no-untyped-def]
    """Return z of unit stiffness that yields at a drift, along a motion of small steps."""
    z, out = 0.0, np.zeros(len(d))
    most = yielding * max(0.5 + shape, 1e-9) ** (-1.0 / sharpness)
    for i in range(len(d)):
        if begins[i]:
            z = d[i]
        else:
            step = d[i] - d[i - 1]
            middle = z
            for half in (0.5, 1.0):  # the midpoint rule
                loading = shape + 0.5 * np.sign(step * middle)
                slope = 1.0 - (abs(middle) / yielding) ** sharpness * loading
                middle = min(max(z + half * step * slope, -most), most)
            z = middle
        out[i] = z
    return out


def _best(left: Callable[[float], float], grid: Array) -> float:
    """Return the least value, near the best of a grid."""
    values = [left(float(x)) for x in grid]
    at = int(np.argmin(values))
    ends = float(grid[max(at - 1, 0)]), float(grid[min(at + 1, len(grid) - 1)])
    return min(values[at], float(minimize_scalar(left, bounds=ends, method="bounded").fun))


def _left(f: Array, columns: Array) -> float:
    """Return the sum of squares of f beside the best sum of columns."""
    columns = columns.reshape(len(f), -1)
    gram, seen = columns.T @ columns, columns.T @ f
    weights = np.linalg.lstsq(gram, seen, rcond=None)[0]
    return float(np.sum((f - columns @ weights) ** 2))


_LEFT: dict[str, Callable[[Port], float]] = {
    "coulomb_friction": of_friction, "bumper": of_bumper, "cubic_stiffness": of_cubic,
    "hysteresis": of_loop,
}  # fmt: skip
