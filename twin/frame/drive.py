"""A linear drive: a slide on a rail that a motor's force moves against viscous friction."""

from __future__ import annotations

from dataclasses import dataclass

from twin.frame.appearance import box, surroundings
from twin.frame.design import check_positive
from twin.frame.mjcf import Document, add, comment
from twin.frame.options import TIMESTEP, options


@dataclass(frozen=True)
class DriveDesign:
    """A slide without a spring: one rigid-body mode.

    The defaults are round numbers of the size of the EMPS benchmark's (Janot, Gautier and Brunot
    2019), whose mass and friction an identification is to find.

    Attributes:
        mass: of all that moves, the motor's inertia included [kg].
        damping: viscous friction [N s/m].
        travel: half of the rail, for the eye [m].
        gravity: [m/s^2].

    Raises:
        ModelError: a number is not positive.
    """

    mass: float = 80.0
    damping: float = 150.0
    travel: float = 0.3
    gravity: float = 9.81

    def __post_init__(self) -> None:
        check_positive(self, ("mass", "damping", "travel"))


def drive_mjcf(design: DriveDesign, name: str = "drive") -> str:
    """Return MJCF: body ``carriage``, joint ``slide``, motor ``force``, sensor ``position``."""
    document = Document.new(name)
    options(document, design.gravity)
    document.section("option").set("timestep", repr(TIMESTEP))
    surroundings(document, 0.4, with_shaker=False)
    world = document.section("worldbody")
    comment(world, "geoms are for the eye: masses stand under inertial")
    for side in (-1, 1):
        box(world, "steel", (0, side * 0.06, 0.02), (design.travel + 0.12, 0.01, 0.02))
    box(world, "brass", (0, 0, 0.03), (design.travel + 0.12, 0.008, 0.008))
    box(world, "motor", (-design.travel - 0.17, 0, 0.05), (0.05, 0.05, 0.05))
    carriage = add(world, "body", name="carriage", pos=(0, 0, 0.06))
    damping = design.damping
    add(carriage, "joint", name="slide", type="slide", axis=(1, 0, 0), damping=damping)
    inertia = tuple(design.mass / 12 * size for size in (0.02, 0.06, 0.06))
    add(carriage, "inertial", pos=(0, 0, 0), mass=design.mass, diaginertia=inertia)
    box(carriage, "aluminium", (0, 0, 0), (0.12, 0.08, 0.02))
    add(document.section("actuator"), "motor", name="force", joint="slide")
    add(document.section("sensor"), "jointpos", name="position", joint="slide")
    return document.text()
