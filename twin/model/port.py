"""Where a structure moves and where something can act on it: ports, bodies, the base."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from twin.arrays import frozen
from twin.errors import ModelError, available

Array = NDArray[np.float64]
PortKind = Literal["drift", "motion", "body", "base", "channel", "actuator"]
AXES = ("x", "y", "z")
GROUND = "ground"
"""The place of kind "base" of a structure whose base can move along one axis only; where it can
move along several the places are "ground.x", "ground.y", "ground.z"."""


@dataclass(frozen=True)
class Port:
    """A direction in which something moves and a force can act: d = row q.

    Attributes:
        name: the MJCF element's own ("storey2"), with the axis where there are several
            ("floor2.x", "floor2.rz").
        kind: "drift" (relative motion: a joint, a tendon, a difference of two motions) or "motion"
            (of a site or body along or about a world axis).
        row: displacement for unit q [unit of the port], (n,).
        unit: "m" or "rad".
        element: what it is in the MJCF ("joint storey2", "body floor2").
        base: what it moves for a unit translation of the whole base along x, y, z, (3,).
        carries: names of the bodies that hang on a joint or tendon and move with it.
        height: of a joint or tendon: what leans over it when it moves [m] (``twin.model.tree``).
    """

    name: str
    kind: PortKind
    row: Array
    unit: str = "m"
    element: str = ""
    base: Array = field(default_factory=lambda: np.zeros(3))
    carries: tuple[str, ...] = ()
    height: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "row", frozen(self.row, float))
        object.__setattr__(self, "base", frozen(self.base, float))


@dataclass(frozen=True)
class Body:
    """A rigid body that moves, or a site of one, whose mass is nothing.

    Attributes:
        mass: [kg].
        translation: motion of its centre of mass along x, y, z for unit q [m], (3, n).
        rotation: rotation about x, y, z for unit q [rad], (3, n).
        weight: stiffness that gravity gives a kilogram there [N/m per kg], (n, n).
        spin: mass matrix of its rotation about its centre, (n, n).
    """

    mass: float
    translation: Array
    rotation: Array
    weight: Array
    spin: Array

    def __post_init__(self) -> None:
        for name in ("translation", "rotation", "weight", "spin"):
            object.__setattr__(self, name, frozen(getattr(self, name), float))

    def within(self, T: Array) -> Body:
        """Return the body for motions q = T z, T (n, k)."""
        weight, spin = T.T @ self.weight @ T, T.T @ self.spin @ T
        return Body(self.mass, self.translation @ T, self.rotation @ T, weight, spin)


@dataclass(frozen=True)
class Base:
    """A translation of everything together with the ground it stands on, along one axis.

    Attributes:
        mass: that moves with it: the structure's and that of bodies without joints [kg].
        fixed_mass: of the bodies without joints alone [kg].
        row: mass coupling with q: the inertia force on q is -row times its acceleration, (n,).
        disp, vel, acc: what each output reads of its displacement, velocity, acceleration, (m,).
        push: force on it for unit inputs that act from outside, (r,).
    """

    mass: float
    fixed_mass: float
    row: Array
    disp: Array
    vel: Array
    acc: Array
    push: Array

    def __post_init__(self) -> None:
        for name in ("row", "disp", "vel", "acc", "push"):
            object.__setattr__(self, name, frozen(getattr(self, name), float))


def find_port(ports: Mapping[str, Port], name: str) -> Port:
    """Return a port by its name, or the relative motion "A-B" of two.

    Raises:
        ModelError: there is no such port; the message lists those there are.
    """
    if name in ports:
        return ports[name]
    for cut, letter in enumerate(name):
        first, second = name[:cut], name[cut + 1 :]
        if letter == "-" and first in ports and second in ports:
            a, b = ports[first], ports[second]
            if a.unit != b.unit:
                raise ModelError(f"{name}: {first} is in {a.unit}, {second} in {b.unit}")
            return Port(name, "drift", a.row - b.row, a.unit, name, a.base - b.base)
    raise ModelError(f"no port '{name}'; there are {available(ports)}")


def distinct(ports: Mapping[str, Port], kind: PortKind | None = None) -> tuple[str, ...]:
    """Return the ports of a kind or of all, one of those that always move in proportion.

    Of these the first that is in metres is kept, else the first.
    """
    kept: list[str] = []
    of_kind = [name for name, port in ports.items() if kind in (port.kind, None)]
    for name in sorted(of_kind, key=lambda name: ports[name].unit != "m"):
        if not any(parallel(ports[name].row, ports[other].row) for other in kept):
            kept.append(name)
    return tuple(name for name in of_kind if name in kept)


def parallel(a: Array, b: Array) -> bool:
    """Return whether ports with these rows, (n,), move in proportion, to one part in 10^6."""
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    return abs(abs(float(a @ b)) / size - 1) < 0.5e-12 if size else False


def ground_inputs(inputs: tuple[str, ...], axes: Mapping[str, Base]) -> dict[str, int]:
    """Return the axes along which the ground is shaken -> the input's column.

    A bare "acc_ground" is along x, or along the only axis the structure can be shaken.
    """
    bare = next(iter(axes)) if len(axes) == 1 else AXES[0]
    names = {"acc_ground": bare} | {f"acc_ground.{axis}": axis for axis in AXES}
    return {names[name]: column for column, name in enumerate(inputs) if name in names}


def base_axis(place: str, axes: Iterable[str]) -> str:
    """Return the axis that a place of kind "base" means: "ground.y" is "y", "ground" the first.

    Args:
        place: of kind "base".
        axes: along which there is a base.

    Raises:
        ModelError: no base moves there.
    """
    there = list(axes)
    named, _, axis = place.rpartition(".")
    if place == GROUND and there:
        return there[0]
    if named == GROUND and axis in there:
        return axis
    names = [GROUND] if len(there) == 1 else [f"{GROUND}.{axis}" for axis in there]
    raise ModelError(f"no place '{place}' where a base moves; there is {available(names)}")


def base_places(base: Mapping[str, Base], ports: Mapping[str, Port]) -> tuple[str, ...]:
    """Return the places of kind "base": axes of a ground that does not move by itself."""
    axes = tuple(base)
    names = (GROUND,) if len(axes) == 1 else tuple(f"{GROUND}.{axis}" for axis in axes)
    return tuple(name for name in names if name not in ports)
