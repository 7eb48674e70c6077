"""The controlled pendulum on the top floor, with motor and encoder, Fig. 8 and eq. (56)."""

from __future__ import annotations

from xml.etree.ElementTree import Element

from twin.frame.design import Pendulum
from twin.frame.mjcf import Document, add

PIVOT = (0.0, -0.048, 0.034)
"""Where the motor's shaft carries the pendulum, from the centre of the top floor [m]."""


def add_pendulum(document: Document, floor: Element, pendulum: Pendulum) -> Element:
    """Hang the pendulum on the floor; a positive angle swings its tip to positive x."""
    body = add(floor, "body", name="pendulum", pos=PIVOT)
    add(
        body,
        "joint",
        name="pendulum",
        type="hinge",
        axis=(0, -1, 0),
        damping=pendulum.damping,
    )
    inertia = pendulum.central_inertia
    add(
        body,
        "inertial",
        pos=(0, 0, -pendulum.centre_distance),
        mass=pendulum.mass,
        diaginertia=(inertia, inertia, inertia / 10),
    )
    add(document.section("actuator"), "motor", name="torque_pendulum", joint="pendulum")
    add(document.section("sensor"), "jointpos", name="angle_pendulum", joint="pendulum")
    return body
