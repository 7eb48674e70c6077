"""What every frame's document has: options, the ground on its suspension, floors, channels."""

from __future__ import annotations

from xml.etree.ElementTree import Element

from twin.frame.design import FrameDesign, Storey
from twin.frame.mjcf import Document, add

CLAMP_SOLREF = (0.002, 1.0)
CLAMP_SOLIMP = (0.9999, 0.9999, 0.001)
"""The stiffest settings that are stable at a step of 1 ms."""

CLAMP_HEIGHT = 0.07
"""Height above the bench of the ground body's origin, where clamps end and beams begin [m]."""
SPAN = 0.30
"""Distance between the beams, length of the rods [m]."""
DEPTH = 0.045
"""Depth of the rods [m]."""
ALUMINIUM = 2700.0
"""Density [kg/m^3]."""


def ground(document: Document, design: FrameDesign, mass: float) -> Element:
    """Add the base plate, its suspension and the clamp that holds it; return its body.

    Args:
        document: gets the body and the clamp.
        design: has the suspension.
        mass: of the plate and of what is fixed to it [kg].
    """
    stiffness, damping = design.suspension
    body = add(document.section("worldbody"), "body", name="ground", pos=(0, 0, CLAMP_HEIGHT))
    add(
        body,
        "joint",
        name="ground",
        type="slide",
        axis=(1, 0, 0),
        stiffness=stiffness,
        damping=damping,
    )
    inertial(body, mass, (0.42, 0.16, 0.02))
    add(
        document.section("equality"),
        "joint",
        name="clamp",
        joint1="ground",
        solref=CLAMP_SOLREF,
        solimp=CLAMP_SOLIMP,
    )
    return body


def inertial(
    body: Element, mass: float, size: tuple[float, float, float], height: float = 0.0
) -> None:
    """Give a body the mass of a homogeneous box of that size [m], centred at that height."""
    x, y, z = (s**2 for s in size)
    inertia = tuple(mass / 12 * s for s in (y + z, x + z, x + y))
    add(body, "inertial", pos=(0, 0, height), mass=mass, diaginertia=inertia)


def rod_height(storey: Storey) -> float:
    """Height of an aluminium rod of the floor's mass, at most 20 mm: the rest is bolted on [m]."""
    return min(round(storey.floor_mass / (ALUMINIUM * SPAN * DEPTH), 4), 0.02)


def channels(
    document: Document, body: Element, name: str, point: tuple[float, float, float]
) -> None:
    """Add the force actuator at that point of the body, and the sensors of ground or floor."""
    add(body, "site", name=f"hit_{name}", pos=point, size=0.003, rgba=(0.85, 0.15, 0.15, 1))
    add(
        document.section("actuator"),
        "motor",
        name=f"force_{name}",
        site=f"hit_{name}",
        gear=(1, 0, 0, 0, 0, 0),
    )
    sensor = document.section("sensor")
    add(sensor, "framelinacc", name=f"acc_{name}", objtype="xbody", objname=name)
    add(sensor, "framepos", name=f"disp_{name}", objtype="xbody", objname=name)
