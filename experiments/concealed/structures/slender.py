"""The cantilever of ten hinges and the drive, assembled by hand.

The beam's coordinates are its hinge angles. Its weight softens it: a piece at an angle stands lower
by its length times half the angle squared, and what stands on it sinks with it.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .structure import Array, Body, Point, Sensor, Shaking, Structure, modal_damping

HINGES, LENGTH, WIDTH, THICKNESS = 10, 0.6, 0.03, 0.0015
YOUNG, DENSITY, GRAVITY = 2.0e11, 7850.0, 9.81
GROUND_KG = 2.0
RATIOS = (0.01, 0.006)
HEIGHTS = {"acc_low": 0.36, "acc_mid": 0.68, "acc_tip": 1.0}
FORCES = {"force_mid": 0.5, "force_tip": 1.0}
DRIVE_KG, DRIVE_NS_M = 80.0, 150.0


def beam(off: Mapping[str, float]) -> Structure:
    """Return the cantilever as built; ``off`` is a factor by "hinge3", "link3" or "damping1"."""
    h = LENGTH / HINGES
    feet = (np.arange(HINGES) + 0.5) * h
    heads = np.append(feet[1:], LENGTH)
    bending = YOUNG * WIDTH * THICKNESS**3 / 12 / h * (1 - 1 / (4 * HINGES**2))
    scales = {f"hinge{i + 1}": bending * off.get(f"hinge{i + 1}", 1.0) for i in range(HINGES)}
    stiffness = np.diag(list(scales.values()))
    mass = np.zeros((HINGES, HINGES))
    bodies = {}
    for i in range(HINGES):
        length = heads[i] - feet[i]
        kg = DENSITY * WIDTH * THICKNESS * length * off.get(f"link{i + 1}", 1.0)
        centre, turn = _at((feet[i] + heads[i]) / 2), (np.arange(HINGES) <= i).astype(float)
        bodies[f"link{i + 1}"] = Body(kg, (Point(centre, {"x": 1.0}),))
        mass += kg * np.outer(centre, centre)
        mass += kg * (length**2 + THICKNESS**2) / 12 * np.outer(turn, turn)
        stiffness -= kg * GRAVITY * _sinking((feet[i] + heads[i]) / 2)
    ratios = tuple(z * off.get(f"damping{i + 1}", 1.0) for i, z in enumerate(RATIOS))
    tilt = {name: (feet <= share * LENGTH).astype(float) for name, share in HEIGHTS.items()}
    sensors = {
        f"{name}.x": Sensor("m/s^2", _at(share * LENGTH), -GRAVITY * tilt[name], {"x": 1.0})
        for name, share in HEIGHTS.items()
    }
    drives = {name: Point(_at(share * LENGTH), {"x": 1.0}) for name, share in FORCES.items()}
    heights = {name: share for name, share in (HEIGHTS | FORCES).items() if name != "force_tip"}
    motions = {f"{name}.x": Point(_at(share * LENGTH), {"x": 1.0})
               for name, share in heights.items()}  # fmt: skip
    alike = {"force_tip.x": "acc_tip.x", "force_tip": "acc_tip.x", "ground": "ground.x"}
    alike |= {name.removesuffix(".x"): name for name in motions}
    kg = GROUND_KG + sum(body.kg for body in bodies.values())
    coupling = sum(body.kg * body.points[0].row for body in bodies.values())
    drifts = {f"hinge{i + 1}": row for i, row in enumerate(np.eye(HINGES))}
    return Structure(
        mass, modal_damping(mass, stiffness, ratios), stiffness, drifts, scales, motions, bodies,
        drives, sensors, {"x": Shaking(np.asarray(coupling), kg)}, GROUND_KG, alike,
    )  # fmt: skip


def drive(off: Mapping[str, float]) -> Structure:
    """Return the slide as built; ``off`` is a factor by "carriage" or "damping1"."""
    one = np.ones(1)
    point = Point(one, {})
    kg = DRIVE_KG * off.get("carriage", 1.0)
    viscous = DRIVE_NS_M * off.get("damping1", 1.0)
    return Structure(
        np.array([[kg]]), np.array([[viscous]]), np.zeros((1, 1)), {"slide": one},
        {"slide": kg * (2 * np.pi * 0.5) ** 2}, {"carriage": point},
        {"carriage": Body(kg, (point,))}, {"force": point},
        {"position": Sensor("m", 0 * one, one, {})}, {}, 0.0,
        {"carriage.x": "carriage"},
    )  # fmt: skip


def _at(height: float) -> Array:
    """Return the row of the sideways motion at a height [m]."""
    feet = (np.arange(HINGES) + 0.5) * LENGTH / HINGES
    return np.asarray(np.maximum(height - feet, 0.0))


def _sinking(height: float) -> Array:
    """Return S for which a height sinks by q' S q / 2: the integral of slope squared below it."""
    feet = (np.arange(HINGES) + 0.5) * LENGTH / HINGES
    highest = np.maximum.outer(feet, feet)
    return np.asarray(np.maximum(height - highest, 0.0))
