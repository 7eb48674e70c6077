"""What the text allows of (60): the absorber of (54)-(56) regulated at 32 Hz, excited by (57).

The paper prints neither the weights of the regulator nor the covariances of the estimator, neither
the level of w(t) nor T_e, and (60) does not say whether the start of the controlled half counts.
The estimator does not matter here: F_e is measured and the plant is the model, so that the
estimate is exact from rest on and the loop of (59) is the state feedback alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import control
import numpy as np
from scipy import signal

from twin.paper import printed
from twin.paper.printed import Array
from twin.paper.recompute import absorber_model
from twin.second_order import SecondOrderModel

TORQUE_WEIGHTS = (1e-2, 1e-1, 1e0)
"""Weights of the squared torque [N m]^2 against the squared floor displacements [m]^2; with less
than the smallest the pendulum swings beyond the horizontal, where (56) means nothing."""

NOISE_STD = (0.0, 0.05)
"""Standard deviations of w(t) [N]."""

RATE = 1 / printed.CONTROL_STEP.value
SWITCH = round(printed.CONTROL_START.value * RATE)
SAMPLES = round(printed.CONTROL_DURATION.value * RATE)


@dataclass(frozen=True)
class Reduction:
    """The reductions of (60), 1 - max|x| with control over max|x| without, for one set of choices.

    Attributes:
        excited: where F_e acts.
        noise_std: of w(t) [N].
        torque_weight: of the regulator.
        whole: over the whole halves, floors 1 and 2.
        steady: over the last 16 s of each half, floors 1 and 2.
        ceiling: no controller does better over the whole halves: the floors start the controlled
            half where the uncontrolled half left them.
        peak_swing: largest pendulum angle under control [rad].
    """

    excited: str
    noise_std: float
    torque_weight: float
    whole: tuple[float, float]
    steady: tuple[float, float]
    ceiling: tuple[float, float]
    peak_swing: float


def _excitation(noise_std: float, seed: int) -> Array:
    time = np.arange(SAMPLES) / RATE
    force = np.zeros(SAMPLES)
    for amplitude, frequency in zip(printed.FORCE_AMPLITUDE, printed.FORCE_FREQUENCY, strict=True):
        force += amplitude.value * np.sin(2 * np.pi * frequency.value * time)
    return force + noise_std * np.random.default_rng(seed).standard_normal(SAMPLES)


def _influences(model: SecondOrderModel) -> dict[str, Array]:
    """Return the readings of T_e: a force on a floor, or the inertia forces of a moving ground.

    The reductions are ratios and do not depend on the scale; each is scaled to 1 N in all.
    """
    floors = np.array([1.0, 1.0, 0.0])
    return {
        "floor 1": np.array([1.0, 0.0, 0.0]),
        "floor 2": np.array([0.0, 1.0, 0.0]),
        "ground acceleration": model.M @ floors / (floors @ model.M @ floors),
    }


def _peaks(motion: Array, start: int, stop: int) -> Array:
    return np.asarray(np.abs(motion[start:stop, :2]).max(axis=0))


def _pair(numbers: Array) -> tuple[float, float]:
    return float(numbers[0]), float(numbers[1])


@cache
def reductions(seed: int = 0) -> tuple[Reduction, ...]:
    """Return (60) for each reading of T_e, noise level and torque weight; ``seed`` is w(t)'s."""
    model = absorber_model()
    n = len(model.M)
    A = model.state_matrix()
    found = []
    for excited, T_e in _influences(model).items():
        forces = np.linalg.solve(model.M, np.column_stack([T_e, [0.0, 0.0, 1.0]]))
        B = np.vstack([np.zeros_like(forces), forces])
        Ad, Bd, *_ = signal.cont2discrete((A, B, np.eye(2 * n), 0 * B), 1 / RATE, method="zoh")
        for noise_std in NOISE_STD:
            force = _excitation(noise_std, seed)[:, None]
            free = _response(Ad, Bd[:, :1], force)
            for weight in TORQUE_WEIGHTS:
                gain, *_ = control.dlqr(Ad, Bd[:, 1:], np.diag([1.0, 1, 0, 0, 0, 0]), weight)
                closed = _response(Ad - Bd[:, 1:] @ gain, Bd[:, :1], force[SWITCH:], free[SWITCH])
                motion = np.vstack([free[:SWITCH], closed])
                half = SWITCH // 2
                before = _peaks(motion, 0, SWITCH)
                steady = _peaks(motion, half, SWITCH)
                found.append(
                    Reduction(
                        excited,
                        noise_std,
                        weight,
                        _pair(1 - _peaks(motion, SWITCH, SAMPLES) / before),
                        _pair(1 - _peaks(motion, SWITCH + half, SAMPLES) / steady),
                        _pair(1 - _peaks(motion, SWITCH, SWITCH + 1) / before),
                        float(np.abs(closed[:, n - 1]).max()),
                    )
                )
    return tuple(found)


def _response(A: Array, B: Array, u: Array, z0: Array | None = None) -> Array:
    """Return the states z(0) .. z(samples - 1), (samples, order)."""
    order = len(A)
    system = signal.dlti(A, B, np.eye(order), np.zeros_like(B), dt=1.0)
    return np.asarray(signal.dlsim(system, u, x0=z0)[1])
