"""Discrete- and continuous-time linear state-space models, eq. (11)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.arrays import frozen

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StateSpace:
    """z(k+1) = A z(k) + B u(k), y(k) = C z(k) + D u(k); continuous-time where ``dt`` is None.

    Examples:
        >>> decay = StateSpace([[-2.0]], [[1.0]], [[1.0]], [[0.0]], None)
        >>> decay.held(0.5).A.round(4).tolist()
        [[0.3679]]
        >>> decay.poles.real.tolist()
        [-2.0]

    Attributes:
        A: state matrix, (order, order).
        B: input influence matrix, (order, inputs).
        C: output influence matrix, (outputs, order).
        D: direct transmission matrix, (outputs, inputs).
        dt: sampling interval [s], or None for a continuous-time model.
        G: observer gain (order, outputs) of eq. (12), where one was identified.

    Source: eqs. (11)-(15).
    """

    A: Array
    B: Array
    C: Array
    D: Array
    dt: float | None
    G: Array | None = None

    def __post_init__(self) -> None:
        for name in ("A", "B", "C", "D"):
            object.__setattr__(self, name, frozen(np.atleast_2d(getattr(self, name))))
        if self.G is not None:
            object.__setattr__(self, "G", frozen(np.atleast_2d(self.G)))
        order, outputs, inputs = len(self.A), len(self.C), self.B.shape[1]
        expected = {"A": (order, order), "B": (order, inputs), "C": (outputs, order)}
        expected["D"] = (outputs, inputs)
        for name, shape in expected.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has shape {getattr(self, name).shape}, expected {shape}")

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.A)

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Eigenvalues of A [rad/s for continuous time, dimensionless for discrete time]."""
        return np.linalg.eigvals(self.A).astype(complex)

    def to_control(self) -> control.StateSpace:
        """Return the same model as a python-control ``StateSpace``."""
        import control  # here, because it brings all of matplotlib with it

        return control.StateSpace(self.A, self.B, self.C, self.D, 0 if self.dt is None else self.dt)

    def simulate(self, u: Array, z0: Array | None = None) -> Array:
        """Return the output (samples, outputs) for the input u (samples, inputs); discrete only."""
        if self.dt is None:
            raise ValueError("simulate needs a discrete-time model; call held(dt) first")
        system = signal.dlti(self.A, self.B, self.C, self.D, dt=self.dt)
        _, y, _ = signal.dlsim(system, np.asarray(u), x0=z0)
        return np.asarray(y)

    def held(self, dt: float) -> StateSpace:
        """Return the discrete-time model for an input held constant between samples."""
        if self.dt is not None:
            raise ValueError("the model is discrete-time already")
        A, B, C, D, _ = signal.cont2discrete((self.A, self.B, self.C, self.D), dt, method="zoh")
        return StateSpace(A, B, C, D, dt)

    def frequency_response(self, frequency_hz: Array) -> NDArray[np.complex128]:
        """Return the FRF (frequencies, outputs, inputs) at the given frequencies [Hz]."""
        s = 2j * np.pi * np.asarray(frequency_hz)
        point = s if self.dt is None else np.exp(s * self.dt)
        resolvent = np.linalg.solve(
            point[:, None, None] * np.eye(self.order) - self.A,
            np.broadcast_to(self.B, (len(point), *self.B.shape)),
        )
        return np.asarray(self.C @ resolvent + self.D)
