"""The closed loop of a controller with a linear plant: stability, margin, steady vibration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.control.absorber import PENDULUM, DesignModel
from twin.control.controller import Controller
from twin.control.sampled import step

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

GRID = 2000
"""Frequencies at which the margin is looked for, besides those around the loop's poles."""


@dataclass(frozen=True)
class SampledPlant:
    """p(k+1) = A p + B u(k), y(k) = C p; p is the state [x, x'] and the torques on their way.

    Attributes:
        A: (order + delay + 1, order + delay + 1).
        B: influence of the torque that the controller gives, (order + delay + 1,).
        C: measurements just before the torque of this instant acts, (outputs, ...).
    """

    A: Array
    B: Array
    C: Array


def sampled(plant: DesignModel, dt: float, delay: int = 1) -> SampledPlant:
    """Return the plant at the controller's instants, the torque held in between."""
    model = plant.continuous()
    order, n = model.order, model.order + delay + 1
    full = step(model.A, model.B, dt)
    A, B, C = np.zeros((n, n)), np.zeros(n), np.zeros((len(model.C), n))
    A[:order, :order] = full.A
    if delay == 0:
        B[:order] = full.held[:, 1]
    else:
        A[:order, order + delay - 1] = full.held[:, 1]
    B[order] = 1.0
    A[order + 1 :, order:-1] = np.eye(delay)
    C[:, :order], C[:, -1] = model.C, model.D[:, 1]
    return SampledPlant(A, B, C)


def closed_loop(controller: Controller, plant: DesignModel, delay: int = 1) -> Array:
    """Return the state matrix of plant, queued torques and controller, at full gain.

    Args:
        controller: its rate is the loop's.
        plant: the linear plant; its measurements are the controller's.
        delay: whole samples between reading and acting.
    """
    p, c = sampled(plant, controller.dt, delay), controller
    u = np.concatenate([c.D_y @ p.C, c.C])
    return np.block([[p.A, np.zeros((len(p.A), len(c.A)))], [c.B_y @ p.C, c.A]]) + np.outer(
        np.concatenate([p.B, c.B_u]), u
    )


def spectral_radius(controller: Controller, plant: DesignModel, delay: int = 1) -> float:
    """Return the largest magnitude of a closed-loop pole; below one the loop is stable."""
    return float(np.max(np.abs(np.linalg.eigvals(closed_loop(controller, plant, delay)))))


def stability_margin(controller: Controller, plant: DesignModel, delay: int = 1) -> float:
    """Return the smallest return difference |1 + loop gain| at the plant's input, the torque.

    Also called modulus margin: the distance of the Nyquist curve from -1. One is the best a
    regulator alone reaches; m allows gains from 1 / (1 + m) to 1 / (1 - m) and phases of
    2 arcsin(m / 2). Zero where the loop is unstable.
    """
    if spectral_radius(controller, plant, delay) >= 1:
        return 0.0
    p, c = sampled(plant, controller.dt, delay), controller
    poles = np.concatenate(
        [np.linalg.eigvals(p.A), np.linalg.eigvals(closed_loop(controller, plant, delay))]
    )
    near = np.abs(np.angle(poles))[:, None] + np.abs(1 - np.abs(poles))[:, None] * np.linspace(
        -3, 3, 31
    )
    angle = np.unique(
        np.clip(np.concatenate([np.linspace(0, np.pi, GRID), near.ravel()]), 0, np.pi)
    )
    point = np.exp(1j * angle)
    own = c.A + np.outer(c.B_u, c.C)
    fed = c.B_y + np.outer(c.B_u, c.D_y)
    measured = _solved(p.A, p.B[:, None], point)
    control = _solved(own, fed, point)
    gain = (c.D_y + c.C @ control)[:, None, :] @ (p.C @ measured)
    return float(np.min(np.abs(1 - gain[:, 0, 0])))


@dataclass(frozen=True)
class SteadyVibration:
    """Amplitudes of the steady vibration under harmonic excitation of unit amplitude.

    Attributes:
        displacement: of the floors, (frequencies, floors).
        angle: of the pendulum, (frequencies,).
        torque: that acts, (frequencies,).
    """

    displacement: ComplexArray
    angle: ComplexArray
    torque: ComplexArray


def steady_vibration(
    controller: Controller | None,
    plant: DesignModel,
    frequency_hz: Array,
    delay: int = 1,
    dt: float = 1 / 32,
) -> SteadyVibration:
    """Return the response at the sampling instants to a continuous harmonic input, exactly.

    Args:
        controller: at full gain, or None for no torque.
        plant: the linear plant.
        frequency_hz: below half the sampling rate, (frequencies,).
        delay: whole samples between reading and acting.
        dt: sampling interval without controller [s].
    """
    s = 2j * np.pi * np.asarray(frequency_hz)
    model = plant.continuous()
    order = model.order
    eye = np.eye(order)
    free = np.linalg.solve(
        s[:, None, None] * eye - model.A, np.broadcast_to(model.B[:, :1], (len(s), order, 1))
    )
    pendulum = plant.index(PENDULUM)
    if controller is None:
        z, torque = free[:, :, 0], np.zeros(len(s), complex)
    else:
        c, p = controller, sampled(plant, controller.dt, delay)
        point = np.exp(s * c.dt)
        # what the excitation alone does over one step: (e^{s dt} - e^{A dt}) times its own motion
        moved = (point[:, None, None] * eye - p.A[:order, :order]) @ free
        direct = model.D[:, 0]
        u_f = c.D_y @ direct + c.D_f
        excited = np.concatenate([np.zeros(len(p.A)), c.B_y @ direct + c.B_f])
        excited = excited + np.concatenate([p.B, c.B_u]) * u_f
        right = np.broadcast_to(excited.astype(complex), (len(s), len(excited))).copy()
        right[:, :order] += moved[:, :, 0]
        loop = closed_loop(c, plant, delay)
        state = np.linalg.solve(point[:, None, None] * np.eye(len(loop)) - loop, right[:, :, None])[
            :, :, 0
        ]
        z = state[:, :order]
        given = state @ np.concatenate([c.D_y @ p.C, c.C]) + u_f
        torque = given / point**delay
    displacement, angle = z @ plant.displacements().T, np.asarray(z[:, pendulum], np.complex128)
    return SteadyVibration(np.asarray(displacement), angle, torque.astype(np.complex128))


def _solved(A: Array, B: Array, point: ComplexArray) -> ComplexArray:
    """Return (point I - A)^-1 B for each point, (points, order, columns)."""
    resolvent = point[:, None, None] * np.eye(len(A)) - A
    return np.asarray(np.linalg.solve(resolvent, np.broadcast_to(B, (len(point), *B.shape))))
