"""A storey whose beams are rigid links between sprung hinges: beam mass and P-Delta by physics.

Both beams of a storey bend alike, so one chain in the plane of symmetry stands for the two: it has
their mass and twice the stiffness. The floor must not turn: the hinge angles of a storey add up to
zero. Pseudo-rigid storeys: Howell, Compliant Mechanisms, 2001, the fixed-guided beam with a
characteristic radius of 5/6, for which static stiffness and first-order P-Delta (6/5 of weight over
length) are those of the beam. Hinge chains: N hinges at the midpoints of N elements; the stiffness
(E J / h)(1 - 1/N^2) makes the static stiffness that of the beam for any N.
"""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree.ElementTree import Element

from twin.frame.design import FrameDesign, Storey
from twin.frame.mjcf import Document, add
from twin.frame.scene import CLAMP_SOLIMP, CLAMP_SOLREF

CHARACTERISTIC_RADIUS = 5 / 6
PSEUDO_RIGID_INERTIA = (CHARACTERISTIC_RADIUS / 4 - 9 / 70) / CHARACTERISTIC_RADIUS
"""Moment of inertia of a pseudo-rigid link about its middle over mass times length squared.

A beam that bends as a fixed-guided one couples its ends by 9/70 of its mass (consistent mass
matrix); a rigid link of 5/6 of that mass does so for this inertia (1/12 would give 5/36).
"""


@dataclass(frozen=True)
class Chain:
    """Hinges of a storey: heights above the lower clamp [m] and stiffness of each [N m/rad]."""

    heights: tuple[float, ...]
    stiffness: float


def chain_of(storey: Storey, design: FrameDesign) -> Chain:
    """Return the hinges that stand for both beams of a storey."""
    length = storey.beam_length
    bending = 2 * storey.young_modulus * storey.second_moment
    if design.kind == "pseudo_rigid":
        margin = (1 - CHARACTERISTIC_RADIUS) / 2
        stiffness = 6 * bending * CHARACTERISTIC_RADIUS**2 / length
        return Chain((margin * length, (1 - margin) * length), stiffness)
    count = design.segments
    element = length / count
    heights = tuple((index + 0.5) * element for index in range(count))
    return Chain(heights, bending / element * (1 - 1 / count**2))


def stub_mass(storey: Storey, design: FrameDesign) -> float:
    """Mass of the beams' piece between a clamp and the hinge next to it [kg]."""
    chain = chain_of(storey, design)
    return storey.beams_mass * chain.heights[0] / storey.beam_length


def add_storey(
    document: Document,
    below: Element,
    design: FrameDesign,
    number: int,
    clamp: tuple[float, float],
) -> Element:
    """Add the links and the floor of a storey to the body below; return the floor's body.

    Args:
        document: gets the drift tendon and the coupling that keeps the floor level.
        below: ground or floor below.
        design: the frame.
        number: of the storey, from 1.
        clamp: height of the lower clamp above the origin of ``below`` and depth of the upper clamp
            below the origin of the floor [m].
    """
    storey = design.storeys[number - 1]
    chain = chain_of(storey, design)
    names = [f"hinge{number}_{index}" for index in range(1, len(chain.heights) + 1)]
    body, base = below, -clamp[0]
    for index, name in enumerate(names):
        height = chain.heights[index]
        is_floor = index == len(names) - 1
        tag = f"floor{number}" if is_floor else f"beam{number}_{index + 1}"
        # The floor's origin lies at its centre, above its hinge; a link's lies at its hinge.
        origin = storey.beam_length + clamp[1] if is_floor else height
        body = add(body, "body", name=tag, pos=(0, 0, origin - base))
        base = origin
        add(
            body,
            "joint",
            name=name,
            type="hinge",
            axis=(0, 1, 0),
            pos=(0, 0, height - origin),
            stiffness=chain.stiffness,
        )
        if not is_floor:
            length = chain.heights[index + 1] - height
            share = PSEUDO_RIGID_INERTIA if design.kind == "pseudo_rigid" else 1 / 12
            _link_inertia(body, storey, length, share)
    _drift(document, number, names, chain, storey.beam_length)
    _level(document, number, names)
    return body


def _link_inertia(body: Element, storey: Storey, length: float, share: float) -> None:
    """Both beams between two hinges, plates; each turns about its own middle, not the frame's."""
    mass = storey.beams_mass * length / storey.beam_length
    turning = share * mass * length**2
    wide, thick = (mass / 12 * size**2 for size in (storey.beam_width, storey.beam_thickness))
    add(
        body,
        "inertial",
        pos=(0, 0, length / 2),
        mass=mass,
        diaginertia=(turning + wide, turning, wide + thick),
    )


def _drift(document: Document, number: int, names: list[str], chain: Chain, length: float) -> None:
    """The tendon ``storeyI``: a hinge at height s moves the floor by L/2 - s, for level floors."""
    drift = add(document.section("tendon"), "fixed", name=f"storey{number}")
    for name, height in zip(names, chain.heights, strict=True):
        add(drift, "joint", joint=name, coef=length / 2 - height)


def _level(document: Document, number: int, names: list[str]) -> None:
    stiff = {"solref": CLAMP_SOLREF, "solimp": CLAMP_SOLIMP}
    equality = document.section("equality")
    if len(names) == 2:
        bottom, top = names
        add(
            equality,
            "joint",
            name=f"level{number}",
            joint1=top,
            joint2=bottom,
            polycoef=(0, -1, 0, 0, 0),
            **stiff,
        )
        return
    tilt = add(document.section("tendon"), "fixed", name=f"tilt{number}")
    for name in names:
        add(tilt, "joint", joint=name, coef=1)
    add(equality, "tendon", name=f"level{number}", tendon1=f"tilt{number}", **stiff)
