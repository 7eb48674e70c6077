"""The discrete-time LQG controller of (59), the load cell's force as a known input.

The text of (59) lets the torque wait one sample for the measurement (its estimate is the predicted
one); here the delay is a parameter, of which one sample is the paper's. The regulator's gain acts
on the state predicted for the instant at which the torque will act.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from twin.control.absorber import PENDULUM, DesignModel
from twin.control.controller import Controller
from twin.control.riccati import Gains, gains
from twin.control.sampled import Step, step
from twin.control.weights import Covariances, Weights
from twin.errors import ControlError

Array = NDArray[np.float64]

HIGHEST_RATE_HZ = 1000.0


def check_rate(rate_hz: float, highest_mode_hz: float) -> None:
    """Check that a controller can run at this rate.

    Raises:
        ControlError: not within 0 to 1000 Hz, or too slow for the model's highest mode.
    """
    if not (math.isfinite(rate_hz) and 0 < rate_hz <= HIGHEST_RATE_HZ):
        raise ControlError(
            f"the plant cannot be stepped at {rate_hz:g} Hz: a rate is above 0 and at most "
            f"{HIGHEST_RATE_HZ:g} Hz, that of the physics"
        )
    if rate_hz <= 2 * highest_mode_hz:
        raise ControlError(
            f"{rate_hz:g} Hz is too slow: the mode at {highest_mode_hz:.4g} Hz needs more than "
            f"{2 * highest_mode_hz:.4g} Hz"
        )


def lqg(
    model: DesignModel,
    rate_hz: float = 32.0,
    weights: Weights | None = None,
    covariances: Covariances | None = None,
    delay: float = 1.5,
    hold: Literal["linear", "constant"] = "linear",
    torque_limit: float = 0.5,
    ramp_s: float = 10.0,
) -> Controller:
    """Design the controller.

    Args:
        model: what the controller believes in.
        rate_hz: sampling rate [Hz].
        weights: of the regulator.
        covariances: of the estimator.
        delay: samples between reading and acting, not necessarily whole ones. Half a sample more
            than the computation's one is the design that stands one sample more of it best.
        hold: the known input between the samples; (59) holds it constant.
        torque_limit: [N m].
        ramp_s: duration of the soft start [s].

    Raises:
        ControlError: a rate that cannot be, an uncontrollable or unstable design.
    """
    _check_numbers(delay, torque_limit, ramp_s)
    frequency = np.abs(np.linalg.eigvals(model.structure.state_matrix()).imag) / (2 * np.pi)
    check_rate(rate_hz, float(frequency.max()))
    dt = 1 / rate_hz
    found = gains(model, dt, weights or Weights(), covariances or Covariances())
    return assemble(model, found, dt, delay, hold, torque_limit, ramp_s)


def assemble(
    model: DesignModel,
    found: Gains,
    dt: float,
    delay: float,
    hold: str,
    torque_limit: float,
    ramp_s: float,
) -> Controller:
    """Return the controller that estimates, predicts over its delay and regulates.

    Its state is [z(k-1|k-1), f(k-1), u(k-1), u(k-2), ...]. With a delay of i + p samples, p < 1,
    the torque u(k) acts from k + i + p on.
    """
    whole, part = divmod(delay, 1.0)
    i = int(whole)
    continuous = model.continuous()
    order, outputs, past = continuous.order, len(continuous.C), i + 2
    n = order + 1 + past
    columns = np.eye(n + outputs + 1)
    z, f_before, u = columns[:order], columns[order], columns[order : order + past + 1]
    y, f = columns[n : n + outputs], columns[-1]  # u[j] is u(k - j)
    first, rest = (step(continuous.A, continuous.B, h * dt) for h in (part, 1 - part))
    full = step(continuous.A, continuous.B, dt)

    def torque(state: Array, over: Step, value: Array) -> Array:
        return np.asarray(over.A @ state + np.outer(over.held[:, 1], value))

    z = torque(torque(z, first, u[i + 2]), rest, u[i + 1])
    if hold == "linear":
        z = z + np.outer(full.B_0[:, 0], f_before) + np.outer(full.B_1[:, 0], f)
    else:
        z = z + np.outer(full.held[:, 0], f_before)
    D = continuous.D
    innovation = y - continuous.C @ z - np.outer(D[:, 0], f) - np.outer(D[:, 1], u[i + 1])
    z = z + found.L @ innovation
    ahead = z
    for j in range(i):
        ahead = torque(torque(ahead, first, u[i + 1 - j]), rest, u[i - j])
    ahead = torque(ahead, first, u[1])
    ahead = ahead + np.outer(step(continuous.A, continuous.B, delay * dt).held[:, 0], f)
    output = -(found.F @ ahead)[0]
    following = np.vstack([z, f, np.zeros((1, len(f))), u[1:past]])
    B_u = np.zeros(n)
    B_u[order + 1] = 1.0
    E = np.zeros((len(model.floors) + 1, n))
    E[:-1, :order] = model.displacements()
    E[-1, model.index(PENDULUM)] = 1.0
    return Controller(
        A=following[:, :n],
        B_y=following[:, n : n + outputs],
        B_f=following[:, -1],
        B_u=B_u,
        C=output[:n],
        D_y=output[n : n + outputs],
        D_f=float(output[-1]),
        dt=dt,
        measurements=model.measurements,
        known_input=model.known_input,
        estimates=(*(f"disp_{floor}" for floor in model.floors), "angle_pendulum"),
        E=E,
        torque_limit=torque_limit,
        ramp_s=ramp_s,
        delay=delay,
    )


def _check_numbers(delay: float, torque_limit: float, ramp_s: float) -> None:
    if not (math.isfinite(delay) and 0 <= delay <= 8):
        raise ControlError(f"the delay must be 0 to 8 samples, not {delay:g}")
    if not (math.isfinite(torque_limit) and torque_limit > 0):
        raise ControlError(f"the torque limit must be positive, not {torque_limit:g} N m")
    if not (math.isfinite(ramp_s) and ramp_s >= 0):
        raise ControlError(f"the soft start must not be negative, not {ramp_s:g} s")
