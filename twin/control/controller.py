"""A digital controller as the lab computer runs it: matrices, a soft start and a torque limit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from twin.arrays import frozen
from twin.presentable import Presentable

Array = NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Controller(Presentable):
    """xi(k+1) = A xi + B_y y + B_f f + B_u u;  v(k) = C xi + D_y y + D_f f;  u = limit(ramp v).

    The controller reads y(k) and f(k) and gives the torque u(k), which acts from instant k on, or
    later where a computation takes its time: the delay it was designed for is in the matrices.

    Attributes:
        A: (states, states).
        B_y: (states, measurements).
        B_f: (states,).
        B_u: (states,), what it remembers of the torque it gave.
        C: (states,).
        D_y: (measurements,).
        D_f: gain from the known input [N m per its unit].
        dt: sampling interval [s].
        measurements: channels of y, in order: accelerations [m/s^2] and angle [rad].
        known_input: channel of f: the load cell's force [N] or the ground's acceleration [m/s^2].
        estimates: channels that ``E`` reads from the state after a step: displacements and angle.
        E: (estimates, states).
        torque_limit: largest torque it asks for [N m].
        ramp_s: time over which the gain rises from zero to one after switching on [s].
        delay: samples between reading and acting that it was designed for.

    Source: eq. (59), with the delayed torques as further states.
    """

    A: Array
    B_y: Array
    B_f: Array
    B_u: Array
    C: Array
    D_y: Array
    D_f: float
    dt: float
    measurements: tuple[str, ...]
    known_input: str
    estimates: tuple[str, ...] = ()
    E: Array = field(default_factory=lambda: np.zeros((0, 0)))
    torque_limit: float = 0.5
    ramp_s: float = 0.0
    delay: float = 1.0

    def __post_init__(self) -> None:
        for name in ("A", "B_y", "B_f", "B_u", "C", "D_y", "E"):
            object.__setattr__(self, name, frozen(getattr(self, name), float))

    def _title(self) -> str:
        return f"controller of {len(self.A)} states at {self.rate_hz:.6g} Hz"

    def _rows(self) -> Iterator[tuple[str, str]]:
        yield "reads", ", ".join((*self.measurements, self.known_input))
        yield "torque limit", f"{self.torque_limit:.4g} N m"
        yield "soft start", f"{self.ramp_s:.4g} s"
        yield "delay", f"{self.delay:.4g} samples"

    @property
    def rate_hz(self) -> float:
        """Sampling rate [Hz]."""
        return 1 / self.dt

    @property
    def ramp_samples(self) -> int:
        """Steps of the soft start."""
        return round(self.ramp_s / self.dt)

    def start(self) -> Running:
        """Return the controller at rest, switched off."""
        return Running(self)


class Running:
    """A controller that runs: it has a state, so it is a class of its own."""

    def __init__(self, controller: Controller) -> None:
        c = controller
        n, m = len(c.A), len(c.measurements)
        self._fused = np.ascontiguousarray(
            np.block([[c.A, c.B_y, c.B_f[:, None]], [c.C[None], c.D_y[None], np.array([[c.D_f]])]])
        )
        self._input = np.zeros(n + m + 1)
        self._xi = self._input[:n]
        self._y = self._input[n : n + m]
        self._result = np.zeros(n + 1)
        self._next = self._result[:n]
        self._B_u = np.array(c.B_u)
        self._fed = np.zeros(n)
        self._E = np.array(c.E)
        self._limit = c.torque_limit
        self._ramp = c.ramp_samples
        self._steps = 0
        self.on = False
        self.limited = 0

    def switch(self, on: bool) -> None:
        """Switch the torque on, with the soft start, or off; the estimator runs all the time."""
        self.on = on
        self._steps = 0

    def step(self, y: Array, f: float) -> float:
        """Return the torque [N m] for the measurements y, (measurements,), and the input f."""
        self._y[:] = y
        self._input[-1] = f
        np.dot(self._fused, self._input, out=self._result)
        torque = 0.0
        if self.on:
            torque = float(self._result[-1])
            self._steps += 1
            if self._steps < self._ramp:
                torque *= self._steps / self._ramp
            if torque > self._limit:
                torque = self._limit
                self.limited += 1
            elif torque < -self._limit:
                torque = -self._limit
                self.limited += 1
        np.multiply(self._B_u, torque, out=self._fed)
        np.add(self._next, self._fed, out=self._xi)
        return torque

    def estimate(self) -> Array:
        """Return the estimates that belong to the last step's instant, (estimates,)."""
        return np.asarray(self._E @ self._xi)
