"""Linear matrices of a structure with named rows: where it moves, is driven and is measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sensor:
    """What a channel sees: acc q'' + disp q, and the ground's acceleration besides.

    Attributes:
        unit: of the channel.
        acc: of the accelerations of the coordinates, (n,).
        disp: of the displacements (a tilted accelerometer sees gravity), (n,).
        ground: of the ground's acceleration, by its axis.
    """

    unit: str
    acc: Array
    disp: Array
    ground: Mapping[str, float]


@dataclass(frozen=True)
class Point:
    """A direction in which a point moves: row q, and ``along`` the ground's motion by its axis."""

    row: Array
    along: Mapping[str, float]


@dataclass(frozen=True)
class Body:
    """A compact mass [kg] and the directions in which it moves."""

    kg: float
    points: tuple[Point, ...]


@dataclass(frozen=True)
class Shaking:
    """How a ground that moves along an axis drags the structure.

    Attributes:
        coupling: the force on the coordinates is -coupling times its acceleration, (n,).
        mass: that moves with it, the base plate's included [kg].
    """

    coupling: Array
    mass: float


@dataclass(frozen=True)
class Structure:
    """M q'' + R q' + K q = forces, q counted from the ground; all in SI units.

    Attributes:
        mass, damping, stiffness: (n, n).
        drifts: relative motions by name -> row, (n,): where springs and laws sit.
        scales: linear stiffness at each drift [N/m, N m/rad].
        motions: translations of points by name.
        bodies: by name.
        drives: actuator -> where and along which direction it pushes.
        sensors: channel -> what it sees.
        shaken: axis -> how the ground drags along it.
        ground_mass: of the base plate [kg].
        alike: other names of the same places -> the name used here.
    """

    mass: Array
    damping: Array
    stiffness: Array
    drifts: Mapping[str, Array]
    scales: Mapping[str, float]
    motions: Mapping[str, Point]
    bodies: Mapping[str, Body]
    drives: Mapping[str, Point]
    sensors: Mapping[str, Sensor]
    shaken: Mapping[str, Shaking]
    ground_mass: float
    alike: Mapping[str, str]

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.mass)

    def row(self, place: str) -> Array:
        """Return the row of a drift or a point's motion."""
        return self.drifts[place] if place in self.drifts else self.motions[place].row

    def modes(self) -> tuple[Array, Array]:
        """Return natural frequencies [rad/s] and mass-normalised shapes (columns)."""
        squares, shapes = eigh(self.stiffness, self.mass)
        return np.sqrt(np.maximum(squares, 0.0)), shapes

    def stiffer(self, place: str, stiffness: float, damping: float = 0.0) -> Structure:
        """Return the structure with a spring and a dashpot along a place's row."""
        return self.held(self.row(place), stiffness, damping)

    def held(self, row: Array, stiffness: float, damping: float) -> Structure:
        """Return the structure with a spring and a dashpot along a row."""
        outer = np.outer(row, row)
        return replace(
            self, damping=self.damping + damping * outer,
            stiffness=self.stiffness + stiffness * outer,
        )  # fmt: skip

    def heavier(self, points: tuple[Point, ...], kg: float) -> Structure:
        """Return the structure with a mass that moves as these points do."""
        mass = self.mass + kg * sum(np.outer(p.row, p.row) for p in points)
        shaken = {
            axis: Shaking(
                s.coupling + kg * sum(p.along.get(axis, 0.0) * p.row for p in points),
                s.mass + kg * sum(p.along.get(axis, 0.0) ** 2 for p in points),
            )
            for axis, s in self.shaken.items()
        }
        return replace(self, mass=np.asarray(mass), shaken=shaken)

    def wider(self) -> Structure:
        """Return the structure with one more coordinate that nothing is attached to yet."""

        def row(values: Array) -> Array:
            return np.append(values, 0.0)

        def square(matrix: Array) -> Array:
            return np.pad(matrix, ((0, 1), (0, 1)))

        def point(p: Point) -> Point:
            return replace(p, row=row(p.row))

        return replace(
            self,
            mass=square(self.mass), damping=square(self.damping), stiffness=square(self.stiffness),
            drifts={k: row(v) for k, v in self.drifts.items()},
            motions={k: point(p) for k, p in self.motions.items()},
            bodies={k: replace(b, points=tuple(map(point, b.points)))
                    for k, b in self.bodies.items()},
            drives={k: point(p) for k, p in self.drives.items()},
            sensors={k: replace(s, acc=row(s.acc), disp=row(s.disp))
                     for k, s in self.sensors.items()},
            shaken={k: replace(s, coupling=row(s.coupling)) for k, s in self.shaken.items()},
        )  # fmt: skip

    def hanging(self, place: str, kg: float, damping: float, stiffness: float) -> Structure:
        """Return the structure with a small oscillator that moves along a point's direction."""
        wide = self.wider()
        point = wide.motions[place]
        own = Point(np.eye(wide.size)[-1], point.along)
        wide = wide.heavier((own,), kg)
        apart = np.outer(own.row - point.row, own.row - point.row)
        return replace(
            wide, damping=wide.damping + damping * apart,
            stiffness=wide.stiffness + stiffness * apart,
        )  # fmt: skip

    def on_soft_ground(self, axis: str, damping: float, stiffness: float) -> Structure:
        """Return the structure on a ground that moves along an axis on a spring and a dashpot."""
        wide = self.wider()
        shaking = wide.shaken[axis]
        own = np.eye(wide.size)[-1]
        square, cross = np.outer(own, own), np.outer(shaking.coupling, own)

        def moved(p: Point) -> Point:
            return replace(p, row=p.row + p.along.get(axis, 0.0) * own)

        return replace(
            wide,
            mass=wide.mass + cross + cross.T + shaking.mass * square,
            damping=wide.damping + damping * square,
            stiffness=wide.stiffness + stiffness * square,
            motions={k: moved(p) for k, p in wide.motions.items()},
            drives={k: moved(p) for k, p in wide.drives.items()},
            sensors={k: replace(s, acc=s.acc + s.ground.get(axis, 0.0) * own)
                     for k, s in wide.sensors.items()},
            shaken={**wide.shaken,
                    axis: replace(shaking, coupling=shaking.coupling + shaking.mass * own)},
        )  # fmt: skip


def modal_damping(mass: Array, stiffness: Array, ratios: tuple[float, ...]) -> Array:
    """Return R with the modes of M and K and these damping ratios; the last holds for the rest."""
    squares, shapes = eigh(stiffness, mass)
    every = np.array([ratios[min(i, len(ratios) - 1)] for i in range(len(squares))])
    spread = mass @ shapes
    return np.asarray(spread @ np.diag(2 * every * np.sqrt(squares)) @ spread.T)
