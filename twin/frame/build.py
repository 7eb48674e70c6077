"""From a design to its MJCF."""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from twin.frame import absorber, appearance, flexible, lumped, scene
from twin.frame.damping import add_modal_damping, clamped_linearisation
from twin.frame.design import FrameDesign, Pendulum, Storey
from twin.frame.mjcf import Document, comment

TIMESTEP = 0.001
STABLE_PHASE = 1.0
"""Largest angular frequency times step: RK4 is stable up to 2.8."""

SHIPPED: dict[str, FrameDesign] = {
    "two_storey_lumped": FrameDesign(kind="lumped"),
    "two_storey": FrameDesign(),
    "two_storey_absorber": FrameDesign(pendulum=Pendulum()),
    "one_storey": FrameDesign(storeys=(Storey(0.65),)),
}
"""The designs of the models that come with the package."""


def to_mjcf(design: FrameDesign, name: str = "frame") -> str:
    """Return the MJCF text of a design.

    Raises:
        ModelError: the frame buckles under its own weight.
    """
    # The frame's damping is that of its modes without pendulum, eq. (55), so it is built twice.
    bare, _ = _undamped(design, name)
    frame = clamped_linearisation(bare)
    document, top = _undamped(design, name)
    add_modal_damping(document, design, frame)
    fastest = math.sqrt(float(np.max(np.linalg.eigvals(_dynamic(frame)).real)))
    document.section("option").set("timestep", repr(_timestep(fastest)))
    if design.pendulum:
        pendulum = absorber.add_pendulum(document, top, design.pendulum)
        appearance.pendulum_geometry(pendulum, design.pendulum)
    return document.text()


def _dynamic(frame: object) -> np.ndarray:
    model = frame.generalised  # type: ignore[attr-defined]
    return np.asarray(np.linalg.solve(model.M, model.K))


def _timestep(fastest: float) -> float:
    """1 ms, or for a frame with fast modes the step that divides it and keeps RK4 stable."""
    return TIMESTEP / max(1, math.ceil(fastest * TIMESTEP / STABLE_PHASE))


def _undamped(design: FrameDesign, name: str) -> tuple[Document, Element]:
    """Return the document without damping and pendulum, and the top floor's body."""
    document = Document.new(name)
    scene.options(document, design)
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
