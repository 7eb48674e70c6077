"""What a frame is made of: numbers in SI units, the paper's as defaults."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from math import isfinite, pi
from typing import Literal

from twin.errors import ModelError

Kind = Literal["lumped", "pseudo_rigid", "hinge_chain"]
KINDS: tuple[Kind, ...] = ("lumped", "pseudo_rigid", "hinge_chain")


def check_positive(owner: object, names: Iterable[str]) -> None:
    """Raise ModelError unless these attributes are finite and larger than zero."""
    for name in names:
        value = getattr(owner, name)
        if not (isfinite(value) and value > 0):
            raise ModelError(f"{type(owner).__name__}: {name} must be positive, not {value}")


def check_damping(
    owner: object, ratios: tuple[float, ...], rayleigh: tuple[float, float] | None
) -> None:
    """Raise ModelError unless damping ratios are in [0, 1), or both of Rayleigh's are not negative.

    Args:
        owner: the design, named in the message.
        ratios: of the modes.
        rayleigh: alpha [1/s] and beta [s], which take the ratios' place; or None.
    """
    name = type(owner).__name__
    given = ratios if rayleigh is None else rayleigh
    if not given or not all(isfinite(r) and r >= 0 for r in given):
        raise ModelError(f"{name}: damping must be given and not negative, not {given}")
    if rayleigh is None and max(given) >= 1:
        raise ModelError(f"{name}: damping ratios must be below 1, not {max(given)}")


def damping_ratio_of(
    ratios: tuple[float, ...], rayleigh: tuple[float, float] | None, mode: int, omega: float
) -> float:
    """Return the damping ratio of a mode (from 0) with angular frequency omega [rad/s]."""
    if rayleigh is not None:
        alpha, beta = rayleigh
        return alpha / (2 * omega) + beta * omega / 2
    return ratios[min(mode, len(ratios) - 1)]


@dataclass(frozen=True)
class Storey:
    """Two flexible beams and the rigid rod (the floor) that they carry.

    Attributes:
        floor_mass: mass of the rod and of what is bolted to it [kg].
        beam_length: free length L between the clamps [m].
        young_modulus: E of the beams [N/m^2].
        second_moment: J of one beam [m^4].
        beam_width: [m]; the paper prints J only, 35 mm by 1 mm gives that J.
        beam_thickness: [m].
        beam_density: [kg/m^3], steel.

    Raises:
        ModelError: a number is not positive and finite.

    Source: eq. (7) and the numbers below it.
    """

    floor_mass: float = 0.65
    beam_length: float = 0.3
    young_modulus: float = 2.0e11
    second_moment: float = 2.917e-12
    beam_width: float = 0.035
    beam_thickness: float = 0.001
    beam_density: float = 7850.0

    def __post_init__(self) -> None:
        check_positive(self, (f.name for f in fields(self)))

    @property
    def stiffness(self) -> float:
        """Lateral stiffness of both beams, clamped at both ends: k = 24 EJ / L^3 [N/m], eq. (7)."""
        return 24 * self.young_modulus * self.second_moment / self.beam_length**3

    @property
    def beams_mass(self) -> float:
        """Mass of both beams [kg]."""
        return 2 * self.beam_density * self.beam_width * self.beam_thickness * self.beam_length


@dataclass(frozen=True)
class Pendulum:
    """The inertial absorber: a physical pendulum hinged on the top floor, with its motor.

    Attributes:
        mass: m3 [kg].
        centre_distance: l, from the pivot to the centre of mass [m].
        inertia: I_zz,3 [kg m^2].
        inertia_about: eq. (56) adds m3 l^2 to I_zz,3, so it is meant about the "centre"; its value
            is that of a rod about its "pivot", which is the other reading.
        damping: viscous damping of the hinge [N m s/rad], none in eq. (56).

    Raises:
        ModelError: a number that cannot be; an inertia about the pivot below m3 l^2.
    """

    mass: float = 0.083
    centre_distance: float = 0.0825
    inertia: float = 8.32e-4
    inertia_about: Literal["centre", "pivot"] = "centre"
    damping: float = 0.0

    def __post_init__(self) -> None:
        check_positive(self, ("mass", "centre_distance", "inertia"))
        if not (isfinite(self.damping) and self.damping >= 0):
            raise ModelError(f"Pendulum: damping must not be negative, not {self.damping}")
        if self.inertia_about not in ("centre", "pivot"):
            raise ModelError(
                f"Pendulum: inertia_about is '{self.inertia_about}', not centre or pivot"
            )
        if self.central_inertia <= 0:
            raise ModelError("Pendulum: inertia about the pivot is less than m l^2")

    @property
    def central_inertia(self) -> float:
        """Moment of inertia about the centre of mass [kg m^2]."""
        if self.inertia_about == "centre":
            return self.inertia
        return self.inertia - self.mass * self.centre_distance**2

    @property
    def pivot_inertia(self) -> float:
        """Moment of inertia about the pivot, the (2, 2) entry of M3 in eq. (56) [kg m^2]."""
        return self.central_inertia + self.mass * self.centre_distance**2


@dataclass(frozen=True)
class Ground:
    """The base plate and the soft suspension it has when its clamp is undone.

    Attributes:
        mass: of the plate [kg].
        frequency_hz: of the whole frame moving as one body on the suspension [Hz].
        damping_ratio: of that motion.

    Raises:
        ModelError: a number is not positive and finite.
    """

    mass: float = 3.0
    frequency_hz: float = 0.5
    damping_ratio: float = 0.05

    def __post_init__(self) -> None:
        check_positive(self, ("mass", "frequency_hz", "damping_ratio"))


@dataclass(frozen=True)
class FrameDesign:
    """A frame of any number of storeys; ``FrameDesign()`` is the paper's, with flexible beams.

    Examples:
        >>> from twin.model import Twin
        >>> three = FrameDesign(storeys=(Storey(0.65), Storey(0.65), Storey(1.55)), kind="lumped")
        >>> len(Twin.of(three).modes().natural_freq)
        3

    Attributes:
        storeys: from the ground up.
        kind: "lumped" (springs without weight, eqs. (2)-(10)), "pseudo_rigid" (each beam a rigid
            link of 5L/6 between two hinges) or "hinge_chain" (``segments`` hinges a storey); the
            last two have the beams' mass, gravity and with it P-Delta.
        segments: hinges in each storey of a "hinge_chain".
        pendulum: the absorber on the top floor, if there is one.
        ground: base plate and suspension.
        damping_ratio: of each mode of the clamped frame without pendulum, exactly; the last one
            holds for all further modes. Eqs. (47)-(48).
        rayleigh: (alpha [1/s], beta [s]) instead of ``damping_ratio``: R = alpha M + beta K on the
            clamped frame, eq. (46), alpha acting on motion relative to the ground.
        gravity: [m/s^2], eq. (56).

    Raises:
        ModelError: no storey, an unknown kind, or a number that cannot be.
    """

    storeys: tuple[Storey, ...] = (Storey(0.65), Storey(1.55))
    kind: Kind = "pseudo_rigid"
    segments: int = 8
    pendulum: Pendulum | None = None
    ground: Ground = field(default_factory=Ground)
    damping_ratio: tuple[float, ...] = (0.0118, 0.0039)
    rayleigh: tuple[float, float] | None = None
    gravity: float = 9.81

    def __post_init__(self) -> None:
        if not self.storeys:
            raise ModelError("FrameDesign: a frame needs at least one storey")
        if self.kind not in KINDS:
            raise ModelError(
                f"FrameDesign: unknown kind '{self.kind}'; kinds are {', '.join(KINDS)}"
            )
        if self.segments < 2:
            raise ModelError(f"FrameDesign: a chain needs 2 segments or more, not {self.segments}")
        check_damping(self, self.damping_ratio, self.rayleigh)
        if not (isfinite(self.gravity) and self.gravity >= 0):
            raise ModelError(f"FrameDesign: gravity must not be negative, not {self.gravity}")

    @classmethod
    def tall(cls, storeys: int, kind: Kind = "pseudo_rigid") -> FrameDesign:
        """Return a frame of that many storeys, the paper's first one repeated below its top one."""
        if storeys < 1:
            raise ModelError("FrameDesign: a frame needs at least one storey")
        return cls((Storey(0.65),) * (storeys - 1) + (Storey(1.55),), kind)

    @property
    def total_mass(self) -> float:
        """Everything that moves when the ground slides [kg]."""
        mass = self.ground.mass + sum(storey.floor_mass for storey in self.storeys)
        if self.kind != "lumped":
            mass += sum(storey.beams_mass for storey in self.storeys)
        return mass + (self.pendulum.mass if self.pendulum else 0.0)

    @property
    def suspension(self) -> tuple[float, float]:
        """Stiffness [N/m] and damping [N s/m] of the ground's suspension."""
        omega = 2 * pi * self.ground.frequency_hz
        return (
            self.total_mass * omega**2,
            2 * self.ground.damping_ratio * omega * self.total_mass,
        )

    def modal_damping(self, mode: int, omega: float) -> float:
        """Return the damping ratio of a mode (from 0) with angular frequency omega [rad/s]."""
        return damping_ratio_of(self.damping_ratio, self.rayleigh, mode, omega)
