"""Second-order models M x'' + R x' + K x = T u and their modes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from twin.arrays import frozen
from twin.errors import ModelError, available
from twin.modal import ModalModel, poles_to_modal
from twin.model.port import GROUND, Port, PortKind, base_axis, distinct, find_port
from twin.state_space import StateSpace

Array = NDArray[np.float64]
PENDULUM = "pendulum"
FLOOR = "floor"


@dataclass(frozen=True)
class SecondOrderModel:
    """Mass, damping and stiffness matrices (the paper's M, R, K) in named coordinates.

    Examples:
        >>> M, K = np.diag([2.0, 2.0]), 800.0 * np.array([[2.0, -1.0], [-1.0, 1.0]])
        >>> frame = SecondOrderModel(M, 0.1 * M, K, ("floor1", "floor2"))
        >>> frame.modes().natural_freq.round(3).tolist()
        [1.967, 5.15]

    Attributes:
        M: mass matrix [kg for displacements, kg m^2 for angles], (n, n).
        R: damping matrix [N s/m], (n, n).
        K: stiffness matrix [N/m], (n, n).
        coordinates: the name of each generalised coordinate ("floor1", "pendulum").

    Source: eqs. (2)-(6), (41), (54).
    """

    M: Array
    R: Array
    K: Array
    coordinates: tuple[str, ...]

    def __post_init__(self) -> None:
        n = len(self.coordinates)
        for name in ("M", "R", "K"):
            object.__setattr__(self, name, frozen(getattr(self, name), float))
            if getattr(self, name).shape != (n, n):
                raise ValueError(
                    f"{name} has shape {getattr(self, name).shape}, expected ({n}, {n})"
                )

    @property
    def ports(self) -> dict[str, Port]:
        """Every coordinate ("floor1") and the drift of every storey ("storey1"), by name."""
        rows = dict(zip(self.coordinates, np.eye(len(self.coordinates)), strict=True))
        floors = [name for name in self.coordinates if name.startswith(FLOOR)]
        found, below = {}, rows.get(GROUND, np.zeros(len(self.coordinates)))
        for name in floors:
            storey = f"storey{name.removeprefix(FLOOR)}"
            carries = tuple(floors[floors.index(name) :])
            drift = rows[name] - below
            found[storey] = Port(storey, "drift", drift, element=f"joint {storey}", carries=carries)
            below = rows[name]
        for name, row in rows.items():
            if name == PENDULUM:
                found[name] = Port(name, "drift", row, "rad", f"joint {name}")
            else:
                found[name] = Port(name, "motion", row, "m", f"body {name}", np.eye(3)[0])
        return found

    @property
    def driven(self) -> dict[str, str]:
        """The pendulum's motor -> the pendulum, where there is one."""
        return {f"torque_{PENDULUM}": PENDULUM} if PENDULUM in self.coordinates else {}

    def port(self, name: str) -> Array:
        """Return the row b with a port's motion = b^T x, (n,); "A-B" is a relative motion.

        Raises:
            ModelError: there is no such port; the message lists those there are.
        """
        return find_port(self.ports, name).row

    def port_of(self, name: str) -> Port:
        """Return a port, or the relative motion "A-B" of two. Raises ModelError: no such port."""
        return find_port(self.ports, name)

    def base_axis(self, place: str) -> str:
        """Return "x". Raises ModelError: the place is no base."""
        return base_axis(place, ("x",))

    def carried(self, name: str) -> float:
        """Return the mass of the floors that a storey carries [kg].

        Raises:
            ModelError: no such storey; the message lists those there are.
        """
        carries = {port.name: port.carries for port in self.ports.values() if port.carries}
        if name not in carries:
            raise ModelError(f"no place '{name}' with floors above; there are {available(carries)}")
        return float(sum(self.M[i, i] for i in map(self.coordinates.index, carries[name])))

    def loaded(self, name: str, mass: float) -> SecondOrderModel:
        """Return the model with a mass on a floor [kg]. Raises ModelError: no such floor."""
        if name not in self.places("body"):
            raise ModelError(f"no place '{name}'; there are {available(self.places('body'))}")
        return self.adding(M=mass, along=self.port(name))

    def places(self, kind: PortKind) -> tuple[str, ...]:
        """Return the names of the places where a structural mechanism of a kind can sit."""
        if kind == "body":
            return tuple(name for name in self.coordinates if name.startswith(FLOOR))
        if kind == "base":
            return () if GROUND in self.coordinates else (GROUND,)
        return distinct(self.ports, kind)

    def adding(
        self,
        *,
        M: Array | float = 0.0,
        R: Array | float = 0.0,
        K: Array | float = 0.0,
        along: Array | None = None,
    ) -> SecondOrderModel:
        """Return the model with matrices (n, n) added, or with numbers times along along^T."""
        outer = np.ones(()) if along is None else np.outer(along, along)
        return replace(self, M=self.M + M * outer, R=self.R + R * outer, K=self.K + K * outer)

    def hanging(
        self, name: str, at: str, mass: float, damping: float, stiffness: float
    ) -> SecondOrderModel:
        """Return the model with a mass on a spring and a dashpot at a port.

        The new coordinate, the last, is the mass's displacement, counted as the port's.
        """
        own = np.eye(len(self.coordinates) + 1)[-1]
        stretch = own - np.append(self.port(at), 0.0)
        M, R, K = (np.pad(matrix, (0, 1)) for matrix in (self.M, self.R, self.K))
        grown = SecondOrderModel(M, R, K, (*self.coordinates, name))
        return grown.adding(M=mass, along=own).adding(R=damping, K=stiffness, along=stretch)

    def on_base(
        self, name: str, axis: str, damping: float, stiffness: float, mass: float | None = None
    ) -> SecondOrderModel:
        """Return the model on a base that gives way; the coordinate comes before the pendulum's.

        The clamped model has no coordinate for the ground. Its forces do not change when all moves
        together, which gives the base's rows: K_gx = -1^T K, K_gg = 1^T K 1 + stiffness. Mass
        between the base and the first floor counts as the floor's.

        Raises:
            ModelError: the axis is not x, the ground moves already, or no mass is given.
        """
        if axis != "x" or mass is None:
            raise ModelError("the base of a chain of storeys moves along x, with a mass of its own")
        if GROUND in self.coordinates:
            raise ModelError(
                "the ground moves already, on a support of its own; it cannot give way"
            )
        n = len(self.coordinates)
        at = self.coordinates.index(PENDULUM) if PENDULUM in self.coordinates else n
        together = np.array([float(c != PENDULUM) for c in self.coordinates])
        relative = np.insert(np.eye(n), at, -together, axis=1)
        M = np.insert(np.insert(self.M, at, 0.0, axis=0), at, 0.0, axis=1)
        R, K = relative.T @ self.R @ relative, relative.T @ self.K @ relative
        names = (*self.coordinates[:at], name, *self.coordinates[at:])
        own = np.eye(n + 1)[at]
        return SecondOrderModel(M, R, K, names).adding(M=mass, R=damping, K=stiffness, along=own)

    def state_matrix(self) -> Array:
        """Return the continuous-time state matrix for the state [x, x'], (2n, 2n)."""
        n = len(self.M)
        lower = -np.linalg.solve(self.M, np.hstack([self.K, self.R]))
        return np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower])

    def modes(self) -> ModalModel:
        """Return the damped modes; the shapes are complex where damping is not proportional."""
        n = len(self.M)
        poles, vectors = np.linalg.eig(self.state_matrix())
        keep = np.flatnonzero(poles.imag > 0)
        if len(keep) < n:
            raise ValueError(
                f"{n - len(keep)} of {n} modes are overdamped or unstable in stiffness"
            )
        keep = keep[np.argsort(np.abs(poles[keep]))]
        freq, damping = poles_to_modal(poles[keep])
        return ModalModel(freq, damping, vectors[:n, keep], self.coordinates)

    def undamped_modes(self) -> ModalModel:
        """Return the modes of M and K alone, real shapes, zero damping (eqs. (9)-(10))."""
        stiffness, shapes = linalg.eigh(self.K, self.M)
        freq = np.sqrt(np.maximum(stiffness, 0)) / (2 * np.pi)
        return ModalModel(freq, np.zeros(len(freq)), shapes, self.coordinates)

    def acceleration_response(self, inputs: tuple[str, ...]) -> StateSpace:
        """Return the continuous-time model from forces on ``inputs`` to all accelerations.

        Raises:
            ValueError: an input is not one of the coordinates.
        """
        n = len(self.M)
        T = np.zeros((n, len(inputs)))
        for column, name in enumerate(inputs):
            T[self.coordinates.index(name), column] = 1.0
        A = self.state_matrix()
        direct = np.asarray(np.linalg.solve(self.M, T), float)
        return StateSpace(A, np.vstack([np.zeros_like(direct), direct]), A[n:], direct, None)
