"""The MJCF of a frame in three dimensions.

A floor has one joint a freedom (``storey2_x``, ``storey2_y``, ``storey2_rz``) against the floor
below, so those are the storey's drifts. All stiffness sits in fixed tendons, one a column and axis
(``storey2_column3_x``): with d = (x, y, rz) of the storey, the top of a column at (a, b) moves by
x - b rz along x, y + a rz along y, and twists by rz.
"""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element

import numpy as np

from twin.frame import space_look
from twin.frame.appearance import surroundings
from twin.frame.damping import add_modal_damping, clamped_linearisation
from twin.frame.mjcf import Document, add, comment
from twin.frame.options import options, timestep_of
from twin.frame.scene import CLAMP_HEIGHT, inertial
from twin.frame.space import Column, Shaker, SpaceFrameDesign

AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "rz": (0, 0, 1)}


def space_mjcf(design: SpaceFrameDesign, name: str = "space_frame") -> str:
    """Return the MJCF text of a design; the same bytes on every machine."""
    document = _undamped(design, name)
    frame = clamped_linearisation(document)
    add_modal_damping(document, design, frame)
    document.section("option").set("timestep", timestep_of(frame))
    return document.text()


def _undamped(design: SpaceFrameDesign, name: str) -> Document:
    document = Document.new(name)
    options(document, design.gravity)
    height = CLAMP_HEIGHT + sum(storey.height for storey in design.storeys)
    surroundings(document, 1.3 * height, with_shaker=False)
    world = document.section("worldbody")
    comment(world, "geoms are for the eye: masses stand under inertial")
    body = add(world, "body", name="ground", pos=(0, 0, CLAMP_HEIGHT))
    plate = design.storeys[0].floor_size
    inertial(body, design.ground_mass, (1.3 * plate[0], 1.3 * plate[1], 0.04), -0.02)
    space_look.ground(body, design.storeys[0])
    _devices(document, body, design, 0)
    height = CLAMP_HEIGHT
    for number, storey in enumerate(design.storeys, start=1):
        space_look.columns(document, number, storey, height)
        height += storey.height
        body = _floor(document, body, design, number)
        _devices(document, body, design, number)
    return document


def _floor(document: Document, below: Element, design: SpaceFrameDesign, number: int) -> Element:
    """Add a floor, its freedoms and the springs of its columns to the body below."""
    storey = design.storeys[number - 1]
    name = f"floor{number}"
    floor = add(below, "body", name=name, pos=(0, 0, storey.height))
    for freedom in design.freedoms:
        kind = "hinge" if freedom == "rz" else "slide"
        add(floor, "joint", name=f"storey{number}_{freedom}", type=kind, axis=AXES[freedom])
    inertial(floor, storey.floor_mass, storey.floor_size)
    space_look.floor(floor, storey)
    for index, load in enumerate(storey.loads, start=1):
        body = add(floor, "body", name=f"{name}_load{index}", pos=(*load.position, 0))
        inertial(body, load.mass, space_look.load_size(load.mass))
        space_look.load(body, load.mass, storey)
    for index, column in enumerate(storey.columns, start=1):
        _springs(document, design, number, index, column)
    sensor = document.section("sensor")
    add(sensor, "framepos", name=f"disp_{name}", objtype="xbody", objname=name)
    return floor


def _springs(
    document: Document, design: SpaceFrameDesign, number: int, index: int, column: Column
) -> None:
    """Add the tendons of a column; one that no freedom of the floor can stretch is left out."""
    a, b = column.position
    rows = ({"x": 1.0, "rz": -b}, {"y": 1.0, "rz": a}, {"rz": 1.0})
    for axis, row, stiffness in zip(AXES, rows, column.stiffness, strict=True):
        used = {freedom: row[freedom] for freedom in design.freedoms if row.get(freedom)}
        if not used:
            continue
        tendon = add(
            document.section("tendon"),
            "fixed",
            name=f"storey{number}_column{index}_{axis}",
            stiffness=stiffness,
        )
        for freedom, coefficient in used.items():
            add(tendon, "joint", joint=f"storey{number}_{freedom}", coef=coefficient)


def _devices(document: Document, body: Element, design: SpaceFrameDesign, floor: int) -> None:
    """Add the accelerometers and the shakers of a floor (0: the ground)."""
    thickness = design.storeys[max(floor - 1, 0)].floor_size[2]
    for device in design.accelerometers:
        if device.floor == floor:
            place_accelerometer(
                document, body, device.name, (*device.position, 0), device.turned, thickness / 2
            )
    for shaker in design.shakers:
        if shaker.floor == floor:
            _shaker(document, body, shaker)


def place_accelerometer(
    document: Document,
    body: Element,
    name: str,
    point: tuple[float, float, float],
    turned: tuple[float, float, float] = (0, 0, 0),
    above: float = 0.0,
) -> None:
    """Add a three-axis accelerometer at a point of a body, drawn as a block on its surface.

    Args:
        document: gets the sensor.
        body: that carries it.
        name: of the sensor.
        point: where it measures, in the body's frame [m].
        turned: its axes, about x, then y, then z of the body [degrees].
        above: height of the surface over the point [m].
    """
    turn = [math.radians(angle) for angle in turned]
    quat = [round(float(part), 12) for part in _quaternion(turn)]
    colour = (0.93, 0.55, 0.13, 1)
    add(body, "site", name=name, pos=point, quat=quat, size=0.003, rgba=colour)
    space_look.accelerometer(body, point, above, quat)
    add(document.section("sensor"), "accelerometer", name=name, site=name)


def _quaternion(turn: list[float]) -> np.ndarray:
    """The rotation about x, then y, then z of fixed axes [rad], scalar first."""
    whole = np.array([1.0, 0, 0, 0])
    for axis, angle in enumerate(turn):
        w, v = math.cos(angle / 2), math.sin(angle / 2) * np.eye(3)[axis]
        whole = np.r_[w * whole[0] - v @ whole[1:], w * whole[1:] + whole[0] * v
                      + np.cross(v, whole[1:])]  # fmt: skip
    return whole


def _shaker(document: Document, body: Element, shaker: Shaker) -> None:
    """Add a motor that pushes at a point along a direction in plan."""
    angle = math.radians(shaker.direction)
    along = tuple(round(part, 12) for part in (math.cos(angle), math.sin(angle)))
    mark = (0.85, 0.15, 0.15, 1)
    add(body, "site", name=shaker.name, pos=(*shaker.position, 0), size=0.005, rgba=mark)
    add(
        document.section("actuator"),
        "motor",
        name=shaker.name,
        site=shaker.name,
        gear=(*along, 0, 0, 0, 0),
    )
