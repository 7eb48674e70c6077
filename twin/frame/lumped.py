"""A storey as a spring without weight, Fig. 3 and eqs. (2)-(7)."""

from __future__ import annotations

from xml.etree.ElementTree import Element

from twin.frame.design import Storey
from twin.frame.mjcf import add


def add_storey(below: Element, storey: Storey, number: int, rise: float) -> Element:
    """Add the floor on a slide joint, its drift, to the body below; return the floor's body."""
    floor = add(below, "body", name=f"floor{number}", pos=(0, 0, rise))
    add(
        floor,
        "joint",
        name=f"storey{number}",
        type="slide",
        axis=(1, 0, 0),
        stiffness=storey.stiffness,
    )
    return floor
