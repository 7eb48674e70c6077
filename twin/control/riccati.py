"""The two Riccati equations behind the controller of (59)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from twin.control.absorber import PENDULUM, DesignModel
from twin.control.sampled import step
from twin.control.weights import Covariances, Weights
from twin.errors import ControlError
from twin.state_space import StateSpace

Array = NDArray[np.float64]

LEAST_CONTROLLABLE = 1e-9
"""A mode that the torque moves less than this, relative to the mode it moves most, is lost."""


@dataclass(frozen=True)
class Gains:
    """The gains of (59) and what they solve.

    Attributes:
        A: sampled state matrix, (order, order).
        B: influence of the torque, held between samples, (order, 1).
        F: regulator, u = -F z, (1, order). The paper's F has the other sign.
        L: estimator, z(k|k) = z(k|k-1) + L (y - y(k|k-1)), (order, outputs). The paper's K is A L.
        P: covariance of z(k) - z(k|k) by the estimator's own assumptions, (order, order).
        cost: solution of the regulator's Riccati equation, (order, order).
    """

    A: Array
    B: Array
    F: Array
    L: Array
    P: Array
    cost: Array


def gains(model: DesignModel, dt: float, weights: Weights, covariances: Covariances) -> Gains:
    """Solve both Riccati equations.

    Args:
        model: what the controller believes in.
        dt: sampling interval [s].
        weights: of the regulator.
        covariances: of the estimator.

    Raises:
        ControlError: a mode that cannot be controlled or observed, or no stabilising solution.
    """
    continuous = model.continuous()
    order = continuous.order
    full = step(continuous.A, continuous.B, dt)
    A, B = full.A, full.held[:, 1:]
    C = continuous.C
    _check_controllable(A, B, dt)
    try:
        cost = linalg.solve_discrete_are(A, B, _cost(model, weights), [[weights.torque]])
        F = np.linalg.solve(B.T @ cost @ B + weights.torque, B.T @ cost @ A)
        # w(k-1), held until k, is in y(k) too: z(k) and y(k) seen from z(k-1) have one noise.
        G, direct = _disturbances(model, continuous, dt, covariances)
        seen = C @ G + direct
        R = np.diag([covariances.acceleration**2] * (len(C) - 1) + [covariances.angle**2])
        S, R = G @ seen.T, R + seen @ seen.T
        P = linalg.solve_discrete_are(A.T, (C @ A).T, G @ G.T, R, s=S)
        L = np.linalg.solve(C @ A @ P @ A.T @ C.T + R, (A @ P @ A.T @ C.T + S).T).T
    except (np.linalg.LinAlgError, ValueError) as error:
        raise ControlError(f"no stabilising LQG solution at {1 / dt:g} Hz: {error}") from None
    for name, loop in (("regulator", A - B @ F), ("estimator", (np.eye(order) - L @ C) @ A)):
        radius = float(np.max(np.abs(np.linalg.eigvals(loop))))
        if radius >= 1:
            raise ControlError(f"unstable design: the {name} has a pole of magnitude {radius:.6g}")
    return Gains(A, B, F, L, P, cost)


def _cost(model: DesignModel, weights: Weights) -> Array:
    """Return the weight of the state [x, x'], (2n, 2n)."""
    n = len(model.structure.M)
    floors = model.displacements()
    rates = np.roll(floors, n, axis=1)
    Q = weights.displacement * floors.T @ floors + weights.velocity * rates.T @ rates
    pendulum = model.index(PENDULUM)
    Q[pendulum, pendulum] += weights.angle
    Q[n + pendulum, n + pendulum] += weights.angular_rate
    return np.asarray(Q)


def _disturbances(
    model: DesignModel, continuous: StateSpace, dt: float, covariances: Covariances
) -> tuple[Array, Array]:
    """Return how white disturbances of unit variance move the state and the outputs."""
    n = len(model.structure.M)
    T = np.eye(n) * covariances.disturbance
    pendulum = model.index(PENDULUM)
    T[pendulum, pendulum] = covariances.torque
    T = np.column_stack([T, model.influence() * covariances.known_input])
    forced = np.linalg.solve(model.structure.M, T)
    G = step(continuous.A, np.vstack([np.zeros_like(forced), forced]), dt).held
    direct = np.vstack(
        [forced[[model.index(floor) for floor in model.floors]], np.zeros((1, n + 1))]
    )
    return G, direct


def _check_controllable(A: Array, B: Array, dt: float) -> None:
    """Raise ControlError where the torque does not reach a mode."""
    poles, left = np.linalg.eig(A.T)
    reach = np.abs(left.T @ B)[:, 0] / np.linalg.norm(left, axis=0)
    weakest = int(np.argmin(reach))
    share = float(reach[weakest] / max(reach.max(), 1e-300))
    if share < LEAST_CONTROLLABLE:
        frequency = abs(np.angle(poles[weakest])) / (2 * np.pi * dt)
        raise ControlError(
            f"uncontrollable design: the torque reaches the mode at {frequency:.4g} Hz with "
            f"{share:.1g} of what it reaches best; {LEAST_CONTROLLABLE:g} is needed"
        )
