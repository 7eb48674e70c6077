"""A lumped frame whose top floor carries a motor-driven pendulum, on an integrator of its own.

Lagrange's equations of the floors x and the angle a of a pendulum of mass m, distance l and
inertia J about its pivot, hinged on the top floor n:

    (m_n + m) x_n'' + m l (a'' cos a - a'^2 sin a) + (damping and springs) = force
    J a'' + m l x_n'' cos a + m g l sin a + c a' + friction = torque
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from .rig import Array, Rig

GRAVITY = 9.81
STICK = 1e-3
"""Rate of the pendulum below which its dry friction falls off [rad/s]."""


@dataclass(frozen=True)
class Absorber:
    """The pendulum and what its motor does to a command.

    Attributes:
        mass: [kg].
        distance: from the pivot to the centre of mass [m].
        inertia: about the pivot [kg m^2].
        damping: of the hinge [N m s/rad].
        friction: dry, of the hinge [N m].
        deadband: torque that the motor swallows [N m].
        delay: of the motor [s].
    """

    mass: float = 0.083
    distance: float = 0.0825
    inertia: float = 8.32e-4 + 0.083 * 0.0825**2
    damping: float = 1e-4
    friction: float = 0.0
    deadband: float = 0.0
    delay: float = 0.0


@njit(cache=True)
def _slope(state, push, torque, floor, M, R, K, n, m, l, J, c, friction):  # type: ignore[no-untyped-def]  # noqa: E741
    """Return rates and accelerations of floors and pendulum."""
    x, v = state[: n + 1], state[n + 1 :]
    angle, rate = x[n], v[n]
    right = np.zeros(n + 1)
    right[:n] = -(K @ x[:n]) - R @ v[:n]
    right[floor] += push
    right[n - 1] += m * l * rate**2 * np.sin(angle)
    right[n] = (
        torque - m * GRAVITY * l * np.sin(angle) - c * rate - friction * np.tanh(rate / STICK)
    )
    whole = np.zeros((n + 1, n + 1))
    for i in range(n):
        whole[i, i] = M[i]
    whole[n - 1, n - 1] += m
    whole[n, n] = J
    whole[n - 1, n] = m * l * np.cos(angle)
    whole[n, n - 1] = m * l * np.cos(angle)
    out = np.empty(2 * n + 2)
    out[: n + 1] = v
    out[n + 1 :] = np.linalg.solve(whole, right)
    return out


@njit(cache=True)
def advance(state, force, torque, floor, step, M, R, K, n, m, l, J, c, friction):  # type: ignore[no-untyped-def]  # noqa: E741
    """Integrate by RK4 over force (steps + 1,) and torque (steps,), held within a step.

    Returns states (steps, 2n + 2) and accelerations (steps, n + 1) at each step's beginning, and
    the state after the last.
    """
    steps = len(torque)
    states, seen = np.empty((steps, 2 * n + 2)), np.empty((steps, n + 1))
    for k in range(steps):
        states[k] = state
        a, b = force[k], force[k + 1]
        middle, t = (a + b) / 2, torque[k]
        k1 = _slope(state, a, t, floor, M, R, K, n, m, l, J, c, friction)
        k2 = _slope(state + step / 2 * k1, middle, t, floor, M, R, K, n, m, l, J, c, friction)
        k3 = _slope(state + step / 2 * k2, middle, t, floor, M, R, K, n, m, l, J, c, friction)
        k4 = _slope(state + step * k3, b, t, floor, M, R, K, n, m, l, J, c, friction)
        seen[k] = k1[n + 1 :]
        state = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return states, seen, state


class ControlledRig:
    """The rig as it runs: one controller's interval after the other."""

    def __init__(self, rig: Rig, absorber: Absorber, floor: int, step_s: float) -> None:
        """Start from rest; the force acts on ``floor``, from 1."""
        self.absorber, self.floor, self.step_s = absorber, floor, step_s
        n = rig.storeys
        self.n = n
        self._matrices = np.array(rig.masses), rig.damping, rig.stiffness
        self.state = np.zeros(2 * n + 2)

    def run(self, force: Array, torque: Array) -> tuple[Array, Array]:
        """Go on over force (steps + 1,) and the motor's torque (steps,).

        Returns states (steps, 2n + 2): floors, angle, their rates; and accelerations.
        """
        one = self.absorber
        states, seen, self.state = advance(
            self.state, force, torque, self.floor - 1, self.step_s, *self._matrices, self.n,
            one.mass, one.distance, one.inertia, one.damping, one.friction,
        )  # fmt: skip
        return states, seen
