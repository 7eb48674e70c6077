"""The portal and the frame with turned sensors, assembled by hand from their drawings.

Coordinates are x, y and twist of each floor's centre against the ground, floor by floor.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from .structure import Array, Body, Point, Sensor, Shaking, Structure, modal_damping

YOUNG, SHEAR, LENGTH, WIDE, DEEP = 2.0e11, 7.9e10, 0.3, 0.003, 0.004
PLATE = (0.36, 0.24)
STEEL = 7850.0
GROUND_KG = 6.0
UNEQUAL = ((-0.15, -0.1), (0.15, -0.04), (0.11, 0.1), (-0.06, 0.05))
SQUARE = ((-0.15, -0.1), (0.15, -0.1), (0.15, 0.1), (-0.15, 0.1))
PORTAL = {
    "columns": UNEQUAL,
    "floors": (3.0, 3.0),
    "loads": ((0.4, (-0.1, 0.07)), (0.8, (0.11, 0.06))),
    "sensors": tuple(
        (f"acc_floor{floor}_{corner}", floor, (sign * 0.17, sign * 0.11), 0.0, axes)
        for floor in (1, 2)
        for corner, sign, axes in (("a", -1, "xy"), ("b", 1, "y"))
    ),
    "drives": tuple(
        (f"force_floor{floor}_{axis}", floor, point, turn)
        for floor in (1, 2)
        for axis, point, turn in (("x", (-0.18, 0.05), 0.0), ("y", (0.12, -0.12), 90.0))
    ),
    "ratios": (0.01, 0.008, 0.008, 0.006),
    "twists": True,
}
ROTATED = {
    "columns": SQUARE,
    "floors": (2.0, 3.0),
    "loads": (None, None),
    "sensors": (
        ("acc_a", 1, (0.1, 0.05), 35.0, "xy"),
        ("acc_b", 2, (-0.1, 0.05), -50.0, "xy"),
    ),
    "drives": (("force_a", 1, (-0.15, 0.0), 20.0), ("force_b", 2, (0.15, 0.0), 65.0)),
    "ratios": (0.01, 0.008),
    "twists": False,
}


def frame(drawing: Mapping[str, Any], off: Mapping[str, float]) -> Structure:
    """Return a frame as built.

    Args:
        drawing: ``PORTAL`` or ``ROTATED``.
        off: name of a floor, a load, a column's axis or "damping1".. -> its factor; else one.
    """
    floors = len(drawing["floors"])
    bodies = _bodies(drawing, off)
    mass = np.zeros((3 * floors, 3 * floors))
    for body in bodies.values():
        mass += body.kg * sum(np.outer(p.row, p.row) for p in body.points)
    for i, kg in enumerate(drawing["floors"]):
        own = kg * off.get(f"floor{i + 1}", 1.0)
        mass[3 * i + 2, 3 * i + 2] += own / 12 * (PLATE[0] ** 2 + PLATE[1] ** 2)
        load = drawing["loads"][i]
        if load:
            own = load[0] * off.get(f"floor{i + 1}_load1", 1.0)
            mass[3 * i + 2, 3 * i + 2] += own * (load[0] / STEEL) ** (2 / 3) / 6
    drifts: dict[str, Array] = {}
    scales: dict[str, float] = {}
    alike: dict[str, str] = {}
    stiffness = np.zeros_like(mass)
    for i in range(floors):
        storey = f"storey{i + 1}"
        axes = {f"{storey}_{axis}": _drift(i, floors, row)
                for axis, row in zip(("x", "y", "rz"), np.eye(3), strict=True)}  # fmt: skip
        columns: dict[str, Array] = {}
        for j, (a, b) in enumerate(drawing["columns"], start=1):
            rows = {"x": (1, 0, -b), "y": (0, 1, a), "rz": (0, 0, 1)}
            for axis, own in zip(rows, _column(), strict=True):
                name = f"{storey}_column{j}_{axis}"
                columns[name] = _drift(i, floors, np.array(rows[axis], float))
                scales[name] = own * off.get(name, 1.0)
                stiffness += scales[name] * np.outer(columns[name], columns[name])
        for axis, row in axes.items():
            scales[axis] = float(sum(
                scales[c] * (r @ row) ** 2 / (row @ row) ** 2 for c, r in columns.items()
            ))  # fmt: skip
        drifts |= axes | columns
    sensors = {f"{name}.{axis}": _sensor(floors, floor, at, turn + 90.0 * (axis == "y"))
               for name, floor, at, turn, axes in drawing["sensors"] for axis in axes}  # fmt: skip
    drives = {name: _point(floors, floor, at, turn) for name, floor, at, turn in drawing["drives"]}
    motions = {f"floor{i + 1}.{axis}": _point(floors, i + 1, (0.0, 0.0), turn)
               for i in range(floors) for axis, turn in (("x", 0.0), ("y", 90.0))}  # fmt: skip
    kg = GROUND_KG + sum(body.kg for body in bodies.values())
    rigid = {"x": np.tile([1.0, 0, 0], floors), "y": np.tile([0, 1.0, 0], floors)}
    shaken = {axis: Shaking(mass @ row, kg) for axis, row in rigid.items()}
    built = Structure(
        mass, np.zeros_like(mass), stiffness, drifts, scales, motions, bodies, drives, sensors,
        shaken, GROUND_KG, alike,
    )  # fmt: skip
    ratios = tuple(z * off.get(f"damping{i + 1}", 1.0) for i, z in enumerate(drawing["ratios"]))
    return _finished(built, ratios, bool(drawing["twists"]))


def _finished(built: Structure, ratios: tuple[float, ...], twists: bool) -> Structure:
    """Take out the twists where a frame has none, name what is alike, add the damping."""
    keep = [i for i in range(built.size) if twists or i % 3 != 2]

    def point(p: Point) -> Point:
        return replace(p, row=p.row[keep])

    drifts: dict[str, Array] = {}
    alike: dict[str, str] = {}
    for name, whole in built.drifts.items():
        row = whole[keep]
        same = next((k for k, v in drifts.items() if np.allclose(v, row, atol=1e-12)), None)
        if same is not None:
            alike[name] = same
        elif np.any(row):
            drifts[name] = row
    square = np.ix_(keep, keep)
    mass, stiffness = built.mass[square], built.stiffness[square]
    return replace(
        built, mass=mass, stiffness=stiffness, damping=modal_damping(mass, stiffness, ratios),
        drifts=drifts, scales={name: built.scales[name] for name in drifts}, alike=alike,
        motions={k: point(p) for k, p in built.motions.items()},
        bodies={k: replace(b, points=tuple(map(point, b.points)))
                for k, b in built.bodies.items()},
        drives={k: point(p) for k, p in built.drives.items()},
        sensors={k: replace(s, acc=s.acc[keep], disp=s.disp[keep])
                 for k, s in built.sensors.items()},
        shaken={k: replace(s, coupling=s.coupling[keep]) for k, s in built.shaken.items()},
    )  # fmt: skip


def _column() -> tuple[float, float, float]:
    """Stiffness of a clamped column along x, along y [N/m] and in torsion [N m/rad]."""
    bending = YOUNG / LENGTH**3
    slender = WIDE / DEEP
    torsion = DEEP * WIDE**3 * (1 / 3 - 0.21 * slender * (1 - slender**4 / 12))
    return bending * DEEP * WIDE**3, bending * WIDE * DEEP**3, SHEAR * torsion / LENGTH


def _bodies(drawing: Mapping[str, Any], off: Mapping[str, float]) -> dict[str, Body]:
    floors = len(drawing["floors"])
    found = {}
    for i, kg in enumerate(drawing["floors"]):
        given = {f"floor{i + 1}": (kg, (0.0, 0.0))}
        if drawing["loads"][i]:
            given[f"floor{i + 1}_load1"] = drawing["loads"][i]
        for name, (m, at) in given.items():
            points = tuple(_point(floors, i + 1, at, turn) for turn in (0.0, 90.0))
            found[name] = Body(m * off.get(name, 1.0), points)
    return found


def _point(floors: int, floor: int, at: tuple[float, float], turn: float) -> Point:
    """Return a point of a floor along a direction [degrees from x]."""
    c, s = (round(float(f(np.radians(turn))), 15) for f in (np.cos, np.sin))
    row = np.zeros(3 * floors)
    row[3 * floor - 3 : 3 * floor] = c, s, s * at[0] - c * at[1]
    return Point(row, {"x": c, "y": s})


def _sensor(floors: int, floor: int, at: tuple[float, float], turn: float) -> Sensor:
    point = _point(floors, floor, at, turn)
    return Sensor("m/s^2", point.row, np.zeros(3 * floors), point.along)


def _drift(storey: int, floors: int, own: Array) -> Array:
    row = np.zeros(3 * floors)
    row[3 * storey : 3 * storey + 3] = own
    if storey:
        row[3 * storey - 3 : 3 * storey] = -own
    return row
