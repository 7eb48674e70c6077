"""Second-order models M x'' + R x' + K x = T u and their modes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from twin.arrays import frozen
from twin.modal import ModalModel, poles_to_modal
from twin.state_space import StateSpace

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SecondOrderModel:
    """Mass, damping and stiffness matrices (the paper's M, R, K) in named coordinates.

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
