"""Shake the ground that any model stands on: all of it is put on a slide of prescribed motion."""

from __future__ import annotations

from xml.etree import ElementTree

import mujoco

from twin.errors import ModelError
from twin.model.port import AXES

LARGE_MASS = 1e9
"""Mass of a driven ground, over that of the whole model: the structure moves it by 1e-9."""

SHAKEN = "shaken ground"
"""Name of the body that everything stands on, and how the names of its drives begin."""

BARE = 1e-9
"""Mass and moments of inertia of the driven ground itself, which must have some [kg, kg m^2]."""

_FIXED = ("light", "camera", "frame")


def drive_name(axis: str) -> str:
    """Return the name of the actuator whose value is the ground's acceleration along an axis."""
    return f"{SHAKEN} {axis}"


def shaken(spec: mujoco.MjSpec, axes: tuple[str, ...], source: str) -> mujoco.MjSpec:
    """Return the model on a ground that is driven along some axes.

    Everything in the world moves along but lights, cameras and planes. What is tied to the world
    by a connection or a weld is tied to the shaken ground.

    Args:
        spec: the model; its actuators as they shall be.
        axes: of "x", "y", "z".
        source: the model's name, for messages.

    Raises:
        ModelError: an unknown axis, or a body that floats on a free joint: it has no ground.
    """
    unknown = [axis for axis in axes if axis not in AXES]
    if unknown:
        raise ModelError(f"{source}: the ground has no axis '{unknown[0]}'; it has x, y, z")
    for joint in spec.joints:
        if joint.type == mujoco.mjtJoint.mjJNT_FREE:
            raise ModelError(
                f"{source}: joint '{joint.name or joint.parent.name}' is free, so that body does "
                "not stand on the ground that is to be shaken"
            )
    spec = spec.copy()
    spec.compiler.savecompiled = False  # else numbers keep six digits
    total = float(spec.compile().body_mass.sum()) + BARE
    mass = LARGE_MASS * total
    root = ElementTree.fromstring(spec.to_xml())
    world = root.find("worldbody")
    assert world is not None
    ground = ElementTree.Element("body", name=SHAKEN)
    for axis in axes:
        along = " ".join(str(int(axis == other)) for other in AXES)
        ElementTree.SubElement(
            ground, "joint", name=drive_name(axis), type="slide", axis=along, armature=repr(mass)
        )
    ElementTree.SubElement(
        ground, "inertial", pos="0 0 0", mass=repr(BARE), diaginertia=" ".join([repr(BARE)] * 3)
    )
    for child in list(world):
        if child.tag not in _FIXED and child.get("type") != "plane":
            world.remove(child)
            ground.append(child)
    world.append(ground)
    for tag in ("connect", "weld"):
        for tie in root.iterfind(f"equality/{tag}[@body1]"):
            for end in ("body1", "body2"):
                if tie.get(end, "world") == "world":
                    tie.set(end, SHAKEN)
    moved = mujoco.MjSpec.from_string(ElementTree.tostring(root, encoding="unicode"))
    moved.modelfiledir = spec.modelfiledir
    for axis in axes:
        drive = moved.add_actuator(name=drive_name(axis), target=drive_name(axis))
        drive.trntype = mujoco.mjtTrn.mjTRN_JOINT
        drive.set_to_motor()
        drive.dyntype = mujoco.mjtDyn.mjDYN_INTEGRATOR
        drive.gear = [mass, 0, 0, 0, 0, 0]
        # the drive carries the weight, too
        drive.biastype = mujoco.mjtBias.mjBIAS_AFFINE
        drive.biasprm[0] = -float(moved.option.gravity[AXES.index(axis)]) * total / mass
    return moved
