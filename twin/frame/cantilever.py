"""A standing cantilever as a chain of hinges, with accelerometers and forces along its height."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree.ElementTree import Element

from twin.errors import ModelError
from twin.frame.appearance import box, surroundings
from twin.frame.damping import add_modal_damping, clamped_linearisation
from twin.frame.design import check_damping, check_positive, damping_ratio_of
from twin.frame.mjcf import Document, add, comment
from twin.frame.options import options, timestep_of
from twin.frame.scene import CLAMP_HEIGHT, inertial
from twin.frame.space_build import place_accelerometer


@dataclass(frozen=True)
class CantileverDesign:
    """A steel strip, clamped at its foot, that bends in the x-z plane under its own weight.

    N elements of length h = L / N bend in hinges at their midpoints. The stiffness
    (E J / h)(1 - 1 / (4 N^2)) makes the tip's static deflection under a force at the tip that of
    the beam, L^3 / (3 E J), for any N.

    Attributes:
        length: L [m].
        width: of the strip [m].
        thickness: of the strip, in the direction of bending [m].
        young_modulus: E [N/m^2].
        density: [kg/m^3].
        hinges: N.
        accelerometers: name -> height over L.
        forces: name -> height over L.
        damping_ratio: of each mode, exactly; the last one holds for all further modes.
        rayleigh: (alpha [1/s], beta [s]) instead.
        ground_mass: of the foot's block [kg], which matters where the ground can move.
        gravity: [m/s^2].

    Raises:
        ModelError: a number that cannot be, fewer than two hinges, a height beyond the tip.
    """

    length: float = 0.6
    width: float = 0.03
    thickness: float = 0.0015
    young_modulus: float = 2.0e11
    density: float = 7850.0
    hinges: int = 10
    accelerometers: tuple[tuple[str, float], ...] = (
        ("acc_low", 0.36),
        ("acc_mid", 0.68),
        ("acc_tip", 1.0),
    )
    forces: tuple[tuple[str, float], ...] = (("force_mid", 0.5), ("force_tip", 1.0))
    damping_ratio: tuple[float, ...] = (0.01, 0.006)
    rayleigh: tuple[float, float] | None = None
    ground_mass: float = 2.0
    gravity: float = 9.81

    def __post_init__(self) -> None:
        check_positive(self, ("length", "width", "thickness", "young_modulus", "density"))
        check_positive(self, ("ground_mass",))
        if self.hinges < 2:
            raise ModelError(f"CantileverDesign: two hinges or more, not {self.hinges}")
        check_damping(self, self.damping_ratio, self.rayleigh)
        for name, share in (*self.accelerometers, *self.forces):
            if not self.element / 2 <= share * self.length <= self.length:
                raise ModelError(
                    f"CantileverDesign: {name} at {share:g} of the height; there is "
                    f"{0.5 / self.hinges:g} (the lowest hinge) to 1"
                )

    @property
    def element(self) -> float:
        """Length h of an element [m]."""
        return self.length / self.hinges

    @property
    def bending(self) -> float:
        """E J [N m^2]."""
        return self.young_modulus * self.width * self.thickness**3 / 12

    @property
    def hinge_stiffness(self) -> float:
        """Of each hinge [N m/rad]."""
        return self.bending / self.element * (1 - 1 / (4 * self.hinges**2))

    @property
    def mass(self) -> float:
        """Of the whole strip [kg]."""
        return self.density * self.width * self.thickness * self.length

    def modal_damping(self, mode: int, omega: float) -> float:
        """Return the damping ratio of a mode (from 0) with angular frequency omega [rad/s]."""
        return damping_ratio_of(self.damping_ratio, self.rayleigh, mode, omega)


def cantilever_mjcf(design: CantileverDesign, name: str = "cantilever") -> str:
    """Return the MJCF text of a design: bodies ``link1``.., joints ``hinge1``.. from the foot up.

    Raises:
        ModelError: the strip buckles under its own weight.
    """
    document = Document.new(name)
    options(document, design.gravity)
    surroundings(document, 1.2 * (CLAMP_HEIGHT + design.length), with_shaker=False)
    world = document.section("worldbody")
    comment(world, "geoms are for the eye: masses stand under inertial")
    body = add(world, "body", name="ground", pos=(0, 0, CLAMP_HEIGHT))
    inertial(body, design.ground_mass, (0.16, 0.16, 0.04), -0.02)
    box(body, "dark_aluminium", (0, 0, -0.02), (0.08, 0.08, 0.02))
    stub = design.element / 2
    box(body, "steel", (0, 0, stub / 2), (design.thickness / 2, design.width / 2, stub / 2))
    for number in range(1, design.hinges + 1):
        body = _link(document, body, design, number)
    structure = clamped_linearisation(document)
    add_modal_damping(document, design, structure)
    document.section("option").set("timestep", timestep_of(structure))
    return document.text()


def _link(document: Document, below: Element, design: CantileverDesign, number: int) -> Element:
    """Add the piece above a hinge, up to the next one or the tip, with what is fixed to it."""
    h = design.element
    foot = (number - 0.5) * h
    head = design.length if number == design.hinges else foot + h
    length = head - foot
    body = add(below, "body", name=f"link{number}", pos=(0, 0, h / 2 if number == 1 else h))
    stiffness = design.hinge_stiffness
    add(body, "joint", name=f"hinge{number}", type="hinge", axis=(0, 1, 0), stiffness=stiffness)
    mass = design.mass * length / design.length
    long, wide, thin = (mass / 12 * s**2 for s in (length, design.width, design.thickness))
    inertia = (long + wide, long + thin, wide + thin)
    add(body, "inertial", pos=(0, 0, length / 2), mass=mass, diaginertia=inertia)
    half = (design.thickness / 2, design.width / 2, length / 2)
    box(body, "steel", (0, 0, length / 2), half)
    for name, share in design.accelerometers:
        if _belongs(share * design.length, foot, head, design.length):
            place_accelerometer(document, body, name, (0, 0, share * design.length - foot))
    for name, share in design.forces:
        if _belongs(share * design.length, foot, head, design.length):
            point = (0, 0, share * design.length - foot)
            add(body, "site", name=name, pos=point, size=0.004, rgba=(0.85, 0.15, 0.15, 1))
            add(
                document.section("actuator"),
                "motor",
                name=name,
                site=name,
                gear=(1, 0, 0, 0, 0, 0),
            )
    return body


def _belongs(height: float, foot: float, head: float, top: float) -> bool:
    """Whether a height lies on the piece from foot to head [m]; the tip is the last one's."""
    return foot <= height < head or (head == top and height >= top)
