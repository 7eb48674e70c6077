"""A structure's linear equations of motion about its rest, with named ports, bodies and outputs.

    M q'' + R q' + K q = B u + sum_j row_j f_j,        y = rest + Cd q + Cv q' + Ca q'' + Cu u

A port is a named row on q: the motion d = row q at one place in one direction, and the place where
a force f enters along it. Nothing here knows what a name means.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.arrays import frozen
from twin.errors import ModelError, available
from twin.model import loading
from twin.model.changed import Changed
from twin.model.port import (
    AXES,
    Base,
    Body,
    Port,
    PortKind,
    base_axis,
    base_places,
    distinct,
    find_port,
    ground_inputs,
)
from twin.state_space import StateSpace

Array = NDArray[np.float64]

__all__ = ["Base", "Body", "LinearModel", "Port", "PortKind"]


@dataclass(frozen=True)
class LinearModel:
    """Linear equations of motion about the rest under gravity.

    Attributes:
        M, R, K: mass, damping, stiffness in the coordinates q, (n, n). In modal coordinates
            M is the identity and K = diag(w^2) until something is added.
        inputs: what u is: actuators, "acc_ground" or "acc_ground.x", ... .
        B: forces on q for unit inputs, (n, r).
        outputs: what y is: sensors by name, "NAME.x" for one axis of a vector sensor.
        Cd, Cv, Ca: outputs for unit q, q', q'', (m, n).
        Cu: outputs for unit inputs directly, (m, r).
        ports: name -> port.
        bodies: name -> body that moves ("body 3" where it has no name).
        sites: name -> site that moves, a body without mass.
        driven: actuators that drive a joint of one freedom -> the joint.
        base: axis that the structure can be shaken along ("x") -> how it couples.
        rest: outputs at rest, (m,) (gravity in an accelerometer along z).
        coordinates: names of q.
        left_out: largest share of a static displacement (force and motion at the same input or
            port) that the coordinates cannot show; 0 where no mode is left out.
        shapes: displacements of the joints for unit q, (nv, n); None where they are not known.
    """

    M: Array
    R: Array
    K: Array
    inputs: tuple[str, ...]
    B: Array
    outputs: tuple[str, ...]
    Cd: Array
    Cv: Array
    Ca: Array
    Cu: Array
    ports: Mapping[str, Port]
    bodies: Mapping[str, Body]
    base: Mapping[str, Base]
    rest: Array
    coordinates: tuple[str, ...]
    left_out: float = 0.0
    sites: Mapping[str, Body] = field(default_factory=dict)
    driven: Mapping[str, str] = field(default_factory=dict)
    shapes: Array | None = None

    def __post_init__(self) -> None:
        n, r, m = len(self.coordinates), len(self.inputs), len(self.outputs)
        shapes = dict.fromkeys(("M", "R", "K"), (n, n)) | {"B": (n, r), "Cu": (m, r)}
        shapes |= dict.fromkeys(("Cd", "Cv", "Ca"), (m, n))
        for name, shape in shapes.items():
            value = frozen(getattr(self, name), float)
            object.__setattr__(self, name, value)
            if value.shape != shape:
                raise ValueError(f"{name} has shape {value.shape}, expected {shape}")
        object.__setattr__(self, "rest", frozen(self.rest, float))

    def __repr__(self) -> str:
        ends = (", ".join(names) or "none" for names in (self.inputs, self.outputs))
        size = f"{len(self.coordinates)} coordinates, {len(self.ports)} ports"
        return f"LinearModel({size}; inputs {next(ends)}; outputs {next(ends)})"

    def port(self, name: str) -> Array:
        """Return the row of a port, (n,); "A-B" is the relative motion of two ports.

        Raises:
            ModelError: there is no such port; the message lists those there are.
        """
        return self.port_of(name).row

    def port_of(self, name: str) -> Port:
        """Return a port, or the relative motion "A-B" of two. Raises ModelError: no such port."""
        return find_port(self.ports, name)

    def base_axis(self, place: str) -> str:
        """Return the axis of a place of kind "base". Raises ModelError: no such base."""
        return base_axis(place, self.base)

    def carried(self, name: str) -> float:
        """Return the mass that hangs on a joint or tendon [kg]. Raises ModelError: none does."""
        return loading.carried(self, name)

    def loaded(self, name: str, mass: float) -> LinearModel:
        """Return the model with a mass at a body's centre or a site [kg].

        Raises:
            ModelError: there is no such body or site that moves.
        """
        return loading.loaded(self, name, mass)

    def places(self, kind: PortKind) -> tuple[str, ...]:
        """Return the names of the places where a mechanism of a kind can sit."""
        if kind == "body":
            return tuple(self.bodies)
        if kind == "base":
            return base_places(self.base, self.ports)
        if kind == "channel":
            return self.outputs
        if kind == "actuator":
            return tuple(name for name in self.inputs if not name.startswith("acc_ground"))
        return distinct(self.ports, kind)

    def adding(
        self,
        *,
        M: Array | float = 0.0,
        R: Array | float = 0.0,
        K: Array | float = 0.0,
        along: Array | None = None,
    ) -> LinearModel:
        """Return the model with matrices added, or with numbers times along along^T.

        Args:
            M: mass, (n, n), or with ``along`` a number [kg].
            R: damping, the same [N s/m].
            K: stiffness, the same [N/m].
            along: a port's row, (n,).
        """
        outer = np.ones(()) if along is None else np.outer(along, along)
        return replace(self, M=self.M + M * outer, R=self.R + R * outer, K=self.K + K * outer)

    def hanging(
        self, name: str, at: str, mass: float, damping: float, stiffness: float
    ) -> LinearModel:
        """Return the model with a mass on a spring and a dashpot at a port.

        Args:
            name: of the new coordinate: the mass's displacement along the port, counted as the
                port's. It is a port of kind "motion", too.
            at: the port.
            mass: of what hangs there [kg].
            damping: of the dashpot [N s/m].
            stiffness: of the spring [N/m].
        """
        port = self.port_of(at)
        n = len(self.coordinates)
        own, stretch = np.eye(n + 1)[n], np.append(-port.row, 1.0)
        swinging = Port(name, "motion", own, port.unit, f"hanging at {at}", port.base)
        grown = self._grown(name)
        base = {
            axis: replace(b, row=b.row + mass * share * own, mass=b.mass + mass * share**2)
            for (axis, b), share in zip(
                grown.base.items(), (port.base[AXES.index(a)] for a in grown.base), strict=True
            )
        }
        ports = Changed(grown.ports, lambda p: p, {name: swinging})
        grown = replace(grown, base=base, ports=ports)._shaken(mass * own, port.base)
        return grown.adding(M=mass, along=own).adding(R=damping, K=stiffness, along=stretch)

    def on_base(
        self, name: str, axis: str, damping: float, stiffness: float, mass: float | None = None
    ) -> LinearModel:
        """Return the model on a base that gives way along one axis.

        Args:
            name: of the new coordinate: the base's displacement [m]. It is a port of kind "motion".
            axis: "x", "y" or "z".
            damping: between base and world [N s/m].
            stiffness: between base and world [N/m].
            mass: of the base alone, in place of the bodies' without joints [kg].

        Raises:
            ModelError: nothing moves along that axis.
        """
        if axis not in self.base:
            raise ModelError(f"no base that moves along '{axis}'; there is {available(self.base)}")
        base, at, n = self.base[axis], AXES.index(axis), len(self.coordinates)
        own = np.eye(n + 1)[n]
        alone = base.fixed_mass if mass is None else mass
        total = base.mass - base.fixed_mass + alone
        grown = self._grown(name)
        coupling = np.zeros((n + 1, n + 1))
        coupling[:n, n] = coupling[n, :n] = base.row
        coupling[n, n] = total
        giving = Port(name, "motion", own, "m", "base", np.eye(3)[at])
        ports = Changed(
            grown.ports, lambda p: replace(p, row=p.row + p.base[at] * own), {name: giving}
        )
        bodies, sites = (
            Changed(kind, lambda b: replace(b, translation=_along(b.translation, at)))
            for kind in (grown.bodies, grown.sites)
        )
        bases = dict(grown.base)
        bases[axis] = replace(
            bases[axis], mass=total, fixed_mass=alone, row=bases[axis].row + total * own
        )
        outputs: dict[str, Any] = {
            "Cd": np.column_stack([self.Cd, base.disp]),
            "Cv": np.column_stack([self.Cv, base.vel]),
            "Ca": np.column_stack([self.Ca, base.acc]),
        }
        B = np.vstack([self.B, base.push])
        grown = replace(grown, B=B, ports=ports, bodies=bodies, sites=sites, base=bases, **outputs)
        grown = grown._shaken(total * own, np.eye(3)[at])
        return grown.adding(M=coupling).adding(R=damping, K=stiffness, along=own)

    def _grown(self, name: str) -> LinearModel:
        """Return the model with one more coordinate that nothing holds, moves or sees yet."""
        n = len(self.coordinates)
        grown = self.within(np.eye(n, n + 1), self.left_out)
        return replace(grown, coordinates=(*self.coordinates, name))

    def _shaken(self, inertia: Array, direction: Array) -> LinearModel:
        """Return the model with the inertia force of a shaken ground on a new coordinate."""
        B = np.array(self.B)
        for axis, column in ground_inputs(self.inputs, self.base).items():
            B[:, column] -= inertia * direction[AXES.index(axis)]
        return replace(self, B=B)

    def within(self, T: Array, left_out: float) -> LinearModel:
        """Return the model for motions q = T z only, T (n, k), and what it lacks (``left_out``)."""
        matrices: dict[str, Any] = {
            **{key: T.T @ getattr(self, key) @ T for key in ("M", "R", "K")},
            **{key: getattr(self, key) @ T for key in ("Cd", "Cv", "Ca")},
        }
        return replace(
            self,
            **matrices,
            B=T.T @ self.B,
            ports=Changed(self.ports, lambda p: replace(p, row=p.row @ T)),
            bodies=Changed(self.bodies, lambda body: body.within(T)),
            sites=Changed(self.sites, lambda site: site.within(T)),
            base={key: replace(b, row=b.row @ T) for key, b in self.base.items()},
            coordinates=tuple(f"q{k + 1}" for k in range(T.shape[1])),
            left_out=left_out,
            shapes=None if self.shapes is None else self.shapes @ T,
        )

    def seeing(self, displacement: Array, velocity: Array) -> LinearModel:
        """Return the model whose outputs are rows of q and of q', each (k, n), added up."""
        k = len(displacement)
        return replace(
            self,
            outputs=tuple(f"y{number}" for number in range(1, k + 1)),
            Cd=displacement,
            Cv=velocity,
            Ca=np.zeros((k, len(self.coordinates))),
            Cu=np.zeros((k, len(self.inputs))),
            rest=np.zeros(k),
            base={},
        )

    def state_space(self) -> StateSpace:
        """Return the continuous-time model of the state [q, q'] from u to y - rest."""
        n = len(self.coordinates)
        lower = -np.linalg.solve(self.M, np.hstack([self.K, self.R]))
        entry = np.asarray(np.linalg.solve(self.M, self.B), float)
        A = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower])
        C = np.hstack([self.Cd, self.Cv]) + self.Ca @ lower
        return StateSpace(A, np.vstack([0 * entry, entry]), C, self.Cu + self.Ca @ entry, None)


def _along(translation: Array, axis: int) -> Array:
    """Return translations that follow the last coordinate along an axis."""
    moved = np.array(translation)
    moved[axis, -1] = 1.0
    return moved
