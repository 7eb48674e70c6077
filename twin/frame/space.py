"""What a frame in three dimensions is made of: columns, floors, sensors and shakers; SI units."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite

from twin.errors import ModelError, available
from twin.frame.design import check_damping, check_positive, damping_ratio_of

Point = tuple[float, float]
FREEDOMS = ("x", "y", "rz")


@dataclass(frozen=True)
class Column:
    """A prismatic column, clamped to the floor below and to the floor above.

    Attributes:
        position: in plan, from the floors' centre [m], (x, y).
        length: free length L between the clamps [m].
        section: size of the rectangular section along x and y [m].
        young_modulus: E [N/m^2].
        shear_modulus: G [N/m^2].

    Raises:
        ModelError: a number is not positive and finite.

    Source: Timoshenko, Strength of Materials, 1930: the clamped beam and the rectangular shaft.
    """

    position: Point
    length: float = 0.3
    section: Point = (0.003, 0.004)
    young_modulus: float = 2.0e11
    shear_modulus: float = 7.9e10

    def __post_init__(self) -> None:
        check_positive(self, ("length", "young_modulus", "shear_modulus"))
        if not all(isfinite(size) and size > 0 for size in self.section):
            raise ModelError(f"Column: section must be positive, not {self.section}")

    @property
    def stiffness(self) -> tuple[float, float, float]:
        """Against a drift along x and along y, 12 E J / L^3 [N/m], and a twist, G Jt / L [N m]."""
        along_x, along_y = self.section
        bending = 12 * self.young_modulus / self.length**3
        short, long = sorted(self.section)
        slender = short / long
        torsion = long * short**3 * (1 / 3 - 0.21 * slender * (1 - slender**4 / 12))
        return (
            bending * along_y * along_x**3 / 12,
            bending * along_x * along_y**3 / 12,
            self.shear_modulus * torsion / self.length,
        )


@dataclass(frozen=True)
class Load:
    """A compact mass that is bolted to a floor.

    Attributes:
        mass: [kg].
        position: in plan, from the floor's centre [m].
    """

    mass: float
    position: Point

    def __post_init__(self) -> None:
        check_positive(self, ("mass",))


def unequal_columns() -> tuple[Column, ...]:
    """Return four columns of which no two stand on a line along x or y.

    Columns on one line along x see the same drift along x wherever they stand on it, so no
    recording could tell them apart.
    """
    return tuple(Column(p) for p in ((-0.15, -0.1), (0.15, -0.04), (0.11, 0.1), (-0.06, 0.05)))


def four_columns(
    half_x: float = 0.15, half_y: float = 0.1, like: Column = Column((0.0, 0.0))
) -> tuple[Column, ...]:
    """Return columns at the corners of a rectangle [m], counter-clockwise from (-x, -y)."""
    corners = ((-half_x, -half_y), (half_x, -half_y), (half_x, half_y), (-half_x, half_y))
    return tuple(replace(like, position=corner) for corner in corners)


@dataclass(frozen=True)
class SpaceStorey:
    """Columns without mass and the rigid floor that they carry.

    Attributes:
        columns: what carries the floor.
        floor_mass: of the homogeneous plate [kg].
        floor_size: of the plate along x, y and z [m].
        loads: what is bolted to it.

    Raises:
        ModelError: no column, columns of different length, or a mass that is not positive.
    """

    columns: tuple[Column, ...] = four_columns()
    floor_mass: float = 3.0
    floor_size: tuple[float, float, float] = (0.36, 0.24, 0.012)
    loads: tuple[Load, ...] = ()

    def __post_init__(self) -> None:
        check_positive(self, ("floor_mass",))
        if not self.columns:
            raise ModelError("SpaceStorey: a storey needs at least one column")
        if len({column.length for column in self.columns}) > 1:
            raise ModelError("SpaceStorey: the columns of a storey have one length")

    @property
    def height(self) -> float:
        """From the floor below to this one, centre to centre [m]."""
        return self.columns[0].length + self.floor_size[2]


@dataclass(frozen=True)
class Accelerometer:
    """A three-axis accelerometer on a floor, the sensor ``name`` of the model.

    Attributes:
        name: of the sensor; its axes are the channels ``name.x``, ``name.y``, ``name.z``.
        floor: from 1; 0 for the ground.
        position: in plan, from the floor's centre [m].
        turned: about x, then y, then z, from the frame's axes to its own [degrees].
    """

    name: str
    floor: int
    position: Point = (0.0, 0.0)
    turned: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Shaker:
    """A shaker's stinger or a hammer's target on a floor, the actuator ``name`` of the model.

    Attributes:
        name: of the actuator.
        floor: from 1.
        position: in plan, from the floor's centre [m].
        direction: of the force in plan, from x towards y [degrees].
    """

    name: str
    floor: int
    position: Point = (0.0, 0.0)
    direction: float = 0.0


@dataclass(frozen=True)
class SpaceFrameDesign:
    """A frame whose floors slide along x and y and twist about the vertical.

    Floors are rigid, columns springs without mass; small motions, no P-Delta.

    Attributes:
        storeys: from the ground up.
        accelerometers: what measures.
        shakers: where forces act.
        freedoms: of every floor against the one below: some of x, y, rz.
        damping_ratio: of each mode, exactly; the last one holds for all further modes.
        rayleigh: (alpha [1/s], beta [s]) instead: R = alpha M + beta K.
        ground_mass: of the base plate [kg], which matters where the ground can move.
        gravity: [m/s^2].

    Raises:
        ModelError: a number that cannot be, a floor that is not there, or a name given twice.
    """

    storeys: tuple[SpaceStorey, ...] = (SpaceStorey(), SpaceStorey())
    accelerometers: tuple[Accelerometer, ...] = ()
    shakers: tuple[Shaker, ...] = ()
    freedoms: tuple[str, ...] = FREEDOMS
    damping_ratio: tuple[float, ...] = (0.01,)
    rayleigh: tuple[float, float] | None = None
    ground_mass: float = 6.0
    gravity: float = 9.81

    def __post_init__(self) -> None:
        check_positive(self, ("ground_mass",))
        if not self.storeys:
            raise ModelError("SpaceFrameDesign: a frame needs at least one storey")
        unknown = [name for name in self.freedoms if name not in FREEDOMS]
        if unknown or not self.freedoms:
            raise ModelError(
                f"SpaceFrameDesign: freedoms are {available(FREEDOMS)}, not {self.freedoms}"
            )
        check_damping(self, self.damping_ratio, self.rayleigh)
        named: set[str] = set()
        devices: tuple[Accelerometer | Shaker, ...] = (*self.accelerometers, *self.shakers)
        for device in devices:
            lowest = 0 if isinstance(device, Accelerometer) else 1
            if not lowest <= device.floor <= len(self.storeys):
                raise ModelError(
                    f"SpaceFrameDesign: {device.name} is on floor {device.floor}; floors are "
                    f"{lowest} to {len(self.storeys)}"
                )
            if device.name in named:
                raise ModelError(f"SpaceFrameDesign: two devices are called {device.name}")
            named.add(device.name)

    def modal_damping(self, mode: int, omega: float) -> float:
        """Return the damping ratio of a mode (from 0) with angular frequency omega [rad/s]."""
        return damping_ratio_of(self.damping_ratio, self.rayleigh, mode, omega)
