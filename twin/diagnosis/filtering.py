"""Innovations of a plant with laws: what a recording says that the model did not foresee.

The gain is the stationary one of the linear part, the laws act in the prediction: a prediction
error method (Ljung 1999, ch. 7) whose likelihood stays smooth where a free simulation loses the
recording, because the filter follows the data.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.plant import Sampled
from twin.mechanisms.mechanism import Law

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Gain:
    """The stationary Kalman gain and its covariances.

    Attributes:
        filtered: x(k|k) = x(k|k-1) + filtered e, (n, m).
        carried: what the innovation says of the force noise, carried into the next step, (n, m).
        predicted: covariance of x(k|k-1), (n, n).
        innovation: covariance of e, (m, m).
    """

    filtered: Array
    carried: Array
    predicted: Array
    innovation: Array

    def whole(self, A: Array) -> Array:
        """Return the gain of the predictor, A filtered + carried, (n, m)."""
        return A @ self.filtered + self.carried


def gain(plant: Sampled, input_noise: Array, output_noise: Array, force_noise: Array) -> Gain:
    """Return the stationary gain for white noise in inputs, outputs and on the coordinates.

    Args:
        plant: n states, r inputs, m outputs.
        input_noise: standard deviations (r,).
        output_noise: (m,).
        force_noise: how white noise of unit variance enters as forces [N], (places, sources).

    Raises:
        numpy.linalg.LinAlgError: the Riccati equation has no stabilising solution.
    """
    enter = np.hstack([(plant.B0 + plant.B1) * input_noise, plant.G @ force_noise])
    seen = np.hstack([plant.plant.D * input_noise, plant.plant.L @ force_noise])
    Q = enter @ enter.T + plant.Q
    Q += 1e-13 * np.trace(Q) / len(Q) * np.eye(len(Q))
    R = seen @ seen.T + np.diag(output_noise**2)
    S = enter @ seen.T
    C = plant.plant.C
    from twin.estimation.kalman import stationary

    # Balanced units: accelerations of microns a second squared beside metres a second squared.
    scale = 1 / np.sqrt(np.diag(R))
    Cs, Rs, Ss = scale[:, None] * C, scale[:, None] * R * scale, S * scale
    P = stationary(*(np.ascontiguousarray(x) for x in (plant.A, Cs, Q, Rs, Ss)))
    if not np.isfinite(P).all():
        raise np.linalg.LinAlgError("the stationary covariance of the filter does not converge")
    Se = Cs @ P @ Cs.T + Rs
    inverse = np.linalg.inv(Se)
    filtered = P @ Cs.T @ inverse
    whole = (plant.A @ P @ Cs.T + Ss) @ inverse
    back = 1 / scale
    return Gain(
        filtered * scale,
        (whole - plant.A @ filtered) * scale,
        P,
        back[:, None] * Se * back,
    )


def recursion(F: Array, g: Array, start: Array | None = None) -> Array:
    """Return x of x(k+1) = F x(k) + g(k), x(0) = start or zero, for all k, (samples, n)."""
    from twin.diagnosis.compiled import march

    x = np.zeros((len(g), len(F)))
    if start is not None:
        x[0] = start
    march(np.ascontiguousarray(F.T, float), np.ascontiguousarray(g, float), x)
    return x


def ahead(u: Array) -> Array:
    """Return the next sample's inputs, the last one repeated, (samples, r)."""
    return np.concatenate([u[1:], u[-1:]])


@dataclass(frozen=True)
class Filtered:
    """Innovations e (samples, m) and predicted states x(k|k-1) (samples, n)."""

    innovations: Array
    states: Array


def linear(
    plant: Sampled, gains: Gain, u: Array, smooth: Array, y: Array, start: Array | None = None
) -> Filtered:
    """Return the innovations of a plant without laws.

    Args:
        plant: the plant.
        gains: its gain.
        u: inputs at the samples, (samples, r).
        smooth: inputs as they drive the states between samples, (samples, r).
        y: outputs, (samples, m).
        start: initial state, or rest.
    """
    K = gains.whole(plant.A)
    F = plant.A - K @ plant.plant.C
    direct = y - u @ plant.plant.D.T
    g = smooth @ plant.B0.T + ahead(smooth) @ plant.B1.T + direct @ K.T
    x = recursion(F, g, start)
    return Filtered(direct - x @ plant.plant.C.T, x)


def innovations_of(
    plants: Sequence[Sampled], gains: Gain, given: Array, y: Array, start: Array | None = None
) -> Array:
    """Return the innovations of several plants without laws, (plants, samples, m).

    Args:
        plants: of one size.
        gains: used for all of them.
        given: inputs and outputs side by side (``side_by_side``).
        y: the outputs, (samples, m).
        start: initial state, or rest.
    """
    from twin.diagnosis.compiled import innovator

    samples, m = y.shape
    n, r = plants[0].plant.C.shape[1], plants[0].plant.D.shape[1]
    driving, felt, steps = [], [], []
    for plant in plants:
        K = gains.whole(plant.A)
        seen = np.vstack([-plant.plant.D.T, np.eye(m)])
        driving.append(np.vstack([plant.B0.T, plant.B1.T, seen @ K.T]))
        felt.append(seen)
        steps.append(plant.A - K @ plant.plant.C)
    innovations = np.empty((len(plants), samples, m))
    innovator(n, m)(
        np.array(steps),
        np.array([plant.plant.C for plant in plants]),
        (given @ np.hstack(driving)).reshape(samples, len(plants), n),
        (given[:, 2 * r :] @ np.hstack(felt)).reshape(samples, len(plants), m),
        np.zeros(n) if start is None else np.ascontiguousarray(start, float),
        innovations,
    )
    return innovations


def side_by_side(u: Array, smooth: Array, y: Array) -> Array:
    """Return all that drives a linear filter, (samples, 3 r + m).

    Inputs as they drive the states at each sample and at the next, inputs at the samples, outputs.
    """
    return np.hstack([smooth, ahead(smooth), u, y])


def smoothed(plant: Sampled, gains: Gain, filtered: Filtered) -> Array:
    """Return the states given the whole recording (Rauch, Tung and Striebel 1965), (samples, n)."""
    updated = filtered.states + filtered.innovations @ gains.filtered.T
    P = gains.predicted
    # the whole gain, since accelerometers feel at once the force noise that moves the states
    F = plant.A - gains.whole(plant.A) @ plant.plant.C
    back = P @ F.T @ np.linalg.pinv(P, rcond=1e-14)
    # x_s(k) = x_f(k) + back (x_s(k+1) - x_p(k+1)), run backwards in time
    g = updated[:-1] - filtered.states[1:] @ back.T
    reverse = np.vstack([updated[-1:], g[::-1]])
    x = recursion(back, np.vstack([reverse[1:], reverse[-1:]]), reverse[0])
    return x[::-1]


def with_laws(
    plants: Sequence[Sampled],
    gains: Gain,
    laws: Sequence[tuple[Law, ...]],
    u: Array,
    smooth: Array,
    y: Array,
    start: Array,
    limits: Array,
    steps: int,
    step_s: float,
    memory: Array | None = None,
    begin_s: float = 0.0,
    held: NDArray[np.bool_] | None = None,
) -> tuple[Array, Array, Array]:
    """Return innovations, predicted states and memories of a plant with laws on one trial.

    Args:
        plants: one a variant, sampled at ``step_s / steps``.
        gains: used for all variants.
        laws: of each variant, in the plants' order.
        u: (variants or 1, samples, r) at the samples.
        smooth: the same as they drive the states.
        y: (variants or 1, samples, m), not a number where it is not compared.
        start: initial state, (n,).
        limits: clipping levels of the outputs, infinite where there is none, (variants, m).
        steps: integration steps a sample.
        step_s: sampling interval [s].
        memory: the laws' internal states at the start, (laws,), or zero.
        begin_s: time of the first sample [s].
        held: which inputs do not change within a sample, (r,); none by default.

    Returns:
        Innovations (variants, samples, m), states x(k|k-1) (variants, samples, n) and internal
        states before each sample (variants, samples, laws).
    """
    from twin.diagnosis.compiled import numbers_of, stepper

    def stack(pick: str) -> Array:
        return np.array([getattr(p, pick) for p in plants])

    def inner(pick: str) -> Array:
        return np.array([getattr(p.plant, pick) for p in plants])

    classes = tuple(type(law) for law in laws[0])
    run = stepper(classes, tuple(len(law.numbers) for law in laws[0]))
    variants, n, (samples, m) = len(plants), len(plants[0].A), y.shape[1:]
    innovations, states = np.empty((variants, samples, m)), np.empty((variants, samples, n))
    memories = np.zeros((variants, samples, len(classes)))
    dense = np.ascontiguousarray
    rates = inner("rate")
    run(
        *(stack(name) for name in ("A", "B0", "B1", "E0", "E1")),
        *(inner(name) for name in ("C", "D", "F", "drift")),
        rates,
        *(rates @ inner(name) for name in ("A", "B", "E")),
        np.array([law.sticks for law in laws[0]], bool),
        dense(gains.filtered),
        dense(gains.carried),
        dense(u),
        dense(smooth),
        dense(y),
        dense(start),
        dense(limits),
        numbers_of(list(laws)),
        np.zeros(len(classes)) if memory is None else dense(memory),
        begin_s,
        steps,
        step_s,
        np.ones(u.shape[-1]) if held is None else 1.0 - held,
        innovations,
        states,
        memories,
    )
    return innovations, states, memories
