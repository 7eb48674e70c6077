"""From a design to its MJCF."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element

from twin.frame import absorber, appearance, flexible, lumped, scene
from twin.frame.cantilever import CantileverDesign, cantilever_mjcf
from twin.frame.damping import add_modal_damping, clamped_linearisation
from twin.frame.design import FrameDesign, Pendulum, Storey
from twin.frame.drive import DriveDesign, drive_mjcf
from twin.frame.mjcf import Document, comment
from twin.frame.options import options, timestep_of
from twin.frame.space import (
    Accelerometer,
    Load,
    Shaker,
    SpaceFrameDesign,
    SpaceStorey,
    unequal_columns,
)
from twin.frame.space_build import space_mjcf

Design = FrameDesign | SpaceFrameDesign | CantileverDesign | DriveDesign

PLANE: dict[str, FrameDesign] = {
    "two_storey_lumped": FrameDesign(kind="lumped"),
    "two_storey": FrameDesign(),
    "two_storey_absorber": FrameDesign(pendulum=Pendulum()),
    "one_storey": FrameDesign(storeys=(Storey(0.65),)),
}
"""The plane frames among the models that come with the package."""

PORTAL = SpaceFrameDesign(
    storeys=(
        SpaceStorey(unequal_columns(), loads=(Load(0.4, (-0.1, 0.07)),)),
        SpaceStorey(unequal_columns(), loads=(Load(0.8, (0.11, 0.06)),)),
    ),
    accelerometers=(
        Accelerometer("acc_ground", 0),
        *(
            Accelerometer(f"acc_floor{floor}_{corner}", floor, (sign * 0.17, sign * 0.11))
            for floor in (1, 2)
            for corner, sign in (("a", -1), ("b", 1))
        ),
    ),
    shakers=tuple(
        Shaker(f"force_floor{floor}_{axis}", floor, point, direction)
        for floor in (1, 2)
        for axis, point, direction in (("x", (-0.18, 0.05), 0.0), ("y", (0.12, -0.12), 90.0))
    ),
    damping_ratio=(0.01, 0.008, 0.008, 0.006),
)
"""A portal of two storeys on four columns each, an eccentric mass on either floor."""

ROTATED = SpaceFrameDesign(
    storeys=(SpaceStorey(floor_mass=2.0), SpaceStorey(floor_mass=3.0)),
    accelerometers=(
        Accelerometer("acc_a", 1, (0.1, 0.05), (0.0, 0.0, 35.0)),
        Accelerometer("acc_b", 2, (-0.1, 0.05), (0.0, 0.0, -50.0)),
    ),
    shakers=(Shaker("force_a", 1, (-0.15, 0.0), 20.0), Shaker("force_b", 2, (0.15, 0.0), 65.0)),
    freedoms=("x", "y"),
    damping_ratio=(0.01, 0.008),
)
"""Two storeys that drift along x and y, seen and driven along none of these axes."""

SHIPPED: dict[str, Design] = {
    **PLANE,
    "portal_3d": PORTAL,
    "rotated_sensors": ROTATED,
    "cantilever": CantileverDesign(),
    "drive": DriveDesign(),
}
"""The designs of the models that come with the package."""


def to_mjcf(design: Design, name: str = "frame") -> str:
    """Return the MJCF text of a design.

    Raises:
        ModelError: the structure buckles under its own weight.
    """
    match design:
        case SpaceFrameDesign():
            return space_mjcf(design, name)
        case CantileverDesign():
            return cantilever_mjcf(design, name)
        case DriveDesign():
            return drive_mjcf(design, name)
        case _:
            return _plane_mjcf(design, name)


def _plane_mjcf(design: FrameDesign, name: str) -> str:
    # The frame's damping is that of its modes without pendulum, eq. (55), so it is built twice.
    bare, _ = _undamped(design, name)
    frame = clamped_linearisation(bare)
    document, top = _undamped(design, name)
    add_modal_damping(document, design, frame)
    document.section("option").set("timestep", timestep_of(frame))
    if design.pendulum:
        pendulum = absorber.add_pendulum(document, top, design.pendulum)
        appearance.pendulum_geometry(pendulum, design.pendulum)
    return document.text()


def _undamped(design: FrameDesign, name: str) -> tuple[Document, Element]:
    """Return the document without damping and pendulum, and the top floor's body."""
    document = Document.new(name)
    options(document, design.gravity)
    height = scene.CLAMP_HEIGHT
    heights = [s.beam_length + scene.rod_height(s) for s in design.storeys]
    appearance.surroundings(document, height + sum(heights))
    comment(document.section("worldbody"), "geoms are for the eye: masses stand under inertial")
    below = scene.ground(document, design, design.ground.mass + _stubs(design, 0))
    appearance.ground_geometry(document, below)
    scene.channels(document, below, "ground", (-0.33, 0, -0.03))
    lower = 0.0
    for number, storey in enumerate(design.storeys, start=1):
        half = scene.rod_height(storey) / 2
        rise = lower + storey.beam_length + half
        mass = storey.floor_mass + _stubs(design, number)
        if design.kind == "lumped":
            floor = lumped.add_storey(below, storey, number, rise)
        else:
            floor = flexible.add_storey(document, below, design, number, (lower, half))
        scene.inertial(floor, mass, (scene.SPAN, scene.DEPTH, 2 * half))
        top = number == len(design.storeys)
        appearance.floor_geometry(floor, storey, with_motor=top and design.pendulum is not None)
        appearance.beam_skins(document, number, storey, height + lower, (height, height + rise))
        scene.channels(document, floor, f"floor{number}", (-scene.SPAN / 2 - 0.008, 0, 0))
        below, lower, height = floor, half, height + rise
    return document, below


def _stubs(design: FrameDesign, level: int) -> float:
    """Mass of the beams' pieces that move with the ground (level 0) or a floor [kg]."""
    if design.kind == "lumped":
        return 0.0
    ends = design.storeys[max(level - 1, 0) : level + 1]
    return sum(flexible.stub_mass(storey, design) for storey in ends)


def write_models(folder: Path) -> tuple[Path, ...]:
    """Write the models that come with the package into a folder; return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, design in SHIPPED.items():
        path = folder / f"{name}.xml"
        path.write_text(to_mjcf(design, name), encoding="utf-8", newline="\n")
        paths.append(path)
    return tuple(paths)
