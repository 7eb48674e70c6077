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
from scipy import linalg, signal

from twin.diagnosis.plant import Sampled
from twin.physics.mechanism import Law

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


def gain(
    plant: Sampled, input_noise: Array, output_noise: Array, force_noise: Array
) -> Gain:
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
    # Balanced units: accelerations of microns a second squared beside metres a second squared.
    scale = 1 / np.sqrt(np.diag(R))
    Cs, Rs, Ss = scale[:, None] * C, scale[:, None] * R * scale, S * scale
    P = np.asarray(linalg.solve_discrete_are(plant.A.T, Cs.T, Q, Rs, s=Ss))
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
    """Return x of x(k+1) = F x(k) + g(k), x(0) = start or zero, for all k, (samples, n).

    Solved in the modes of F, each a first-order filter.
    """
    poles, V = np.linalg.eig(F)
    if np.linalg.cond(V) > 1e10:
        return _stepwise(F, g, start)
    modal = g @ np.linalg.inv(V).T
    initial = np.zeros(len(F)) if start is None else start
    modal0 = np.linalg.solve(V, initial.astype(complex))
    out = np.empty((len(g), len(F)), complex)
    out[0] = modal0
    for i, pole in enumerate(poles):
        tail, _ = signal.lfilter([1.0], [1.0, -pole], modal[:-1, i], zi=[pole * modal0[i]])
        out[1:, i] = tail
    return np.asarray((out @ V.T).real)


def _stepwise(F: Array, g: Array, start: Array | None) -> Array:
    x = np.zeros((len(g), len(F)))
    if start is not None:
        x[0] = start
    for k in range(len(g) - 1):
        x[k + 1] = F @ x[k] + g[k]
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


def effect_of_force(plant: Sampled, gains: Gain, law: int, force: Array) -> Array:
    """Return the innovations that a law's known force history (samples,) adds, (samples, m)."""
    K = gains.whole(plant.A)
    F = plant.A - K @ plant.plant.C
    seen = np.outer(force, plant.plant.F[:, law])
    g = np.outer(force, plant.E0[:, law]) + np.outer(ahead(force[:, None])[:, 0], plant.E1[:, law])
    x = recursion(F, g - seen @ K.T)
    return -(seen + x @ plant.plant.C.T)


def effect_of_start(plant: Sampled, gains: Gain, samples: int) -> Array:
    """Return the innovations of unit initial states, (n, samples, m)."""
    F = plant.A - gains.whole(plant.A) @ plant.plant.C
    n = len(F)
    out = np.zeros((n, samples, len(plant.plant.C)))
    power = np.eye(n)
    for k in range(samples):
        out[:, k] = -(plant.plant.C @ power).T
        power = F @ power
        if k % 64 == 63 and np.abs(power).max() < 1e-9:
            break
    return out


def smoothed(plant: Sampled, gains: Gain, filtered: Filtered) -> Array:
    """Return the states given the whole recording (Rauch, Tung and Striebel 1965), (samples, n)."""
    updated = filtered.states + filtered.innovations @ gains.filtered.T
    P = gains.predicted
    Pf = P - gains.filtered @ plant.plant.C @ P
    back = Pf @ plant.A.T @ np.linalg.pinv(P, rcond=1e-14)
    # x_s(k) = x_f(k) + back (x_s(k+1) - x_p(k+1)), run backwards in time
    g = updated[:-1] - filtered.states[1:] @ back.T
    reverse = np.vstack([updated[-1:], g[::-1]])
    x = recursion(back, np.vstack([reverse[1:], reverse[-1:]]), reverse[0])
    return x[::-1]


def with_laws(
    plants: Sequence[Sequence[Sampled]],
    gains: Sequence[Gain],
    laws: Sequence[Law],
    u: Array,
    smooth: Array,
    y: Array,
    start: Array,
    limits: Array,
    steps: int,
    step_s: float,
) -> tuple[Array, Array]:
    """Return innovations and predicted states of variants of a plant with laws.

    Args:
        plants: [trial][variant], sampled at ``step_s / steps``.
        gains: one a trial.
        laws: in the plants' order; their parameters are numbers or (1, variants).
        u: (trials, variants or 1, samples, r) at the samples, trials padded to one length.
        smooth: the same as they drive the states.
        y: (trials, variants or 1, samples, m).
        start: initial states, (trials, n).
        limits: clipping levels of the outputs, infinite where there is none, (1, variants, m).
        steps: integration steps a sample.
        step_s: sampling interval [s].

    Returns:
        Innovations (trials, variants, samples, m) and states (trials, variants, samples, n).
    """
    def stack(pick: str) -> Array:
        return np.array([[getattr(p, pick) for p in row] for row in plants])

    def inner(pick: str) -> Array:
        return np.array([[getattr(p.plant, pick) for p in row] for row in plants])

    A, B0, B1, E0, E1 = (stack(name) for name in ("A", "B0", "B1", "E0", "E1"))
    C, D, Fd = (inner(name) for name in ("C", "D", "F"))
    pick = np.concatenate([inner("drift"), inner("rate")], axis=2)  # (t, v, 2 laws, n)
    count = len(laws)
    trials, variants, n = A.shape[0], A.shape[1], A.shape[2]
    samples, m = y.shape[2], y.shape[3]
    Kf = np.array([g.filtered for g in gains])[:, None]
    Kw = np.array([g.carried for g in gains])[:, None]
    direct = _entered(D, u)
    share = np.arange(steps + 1) / steps
    following = np.concatenate([smooth[:, :, 1:], smooth[:, :, -1:]], axis=2)
    driven = []
    for s in range(steps):
        low = smooth + share[s] * (following - smooth)
        high = smooth + share[s + 1] * (following - smooth)
        driven.append(_entered(B0, low) + _entered(B1, high))
    h = step_s / steps
    x = np.broadcast_to(start[:, None, :], (trials, variants, n))[..., None].copy()
    memory = np.zeros((count, trials, variants))
    innovations = np.empty((samples, trials, variants, m))
    states = np.empty((samples, trials, variants, n))
    remembers = any(law.memory for law in laws)
    clip = limits if np.any(np.isfinite(limits)) else None

    def forces(x: Array, memory: Array, t: float) -> Array:
        motion = (pick @ x)[..., 0]
        out = np.empty((trials, variants, count, 1))
        for j, law in enumerate(laws):
            out[:, :, j, 0] = law.force(motion[:, :, j], motion[:, :, count + j], memory[j], t)
        return out

    def recall(memory: Array, x: Array, after: Array) -> Array:
        before, now = (pick @ x)[..., 0], (pick @ after)[..., 0]
        return np.array(
            [law.remember(memory[j], before[:, :, j], now[:, :, j]) for j, law in enumerate(laws)]
        )

    outputs = np.moveaxis(y, 2, 0)
    both = E0 + E1
    f = forces(x, memory, 0.0)
    for k in range(samples):
        t = k * step_s
        predicted = (C @ x + Fd @ f)[..., 0] + direct[k]
        if clip is not None:
            predicted = np.clip(predicted, -clip, clip)
        e = outputs[k] - predicted
        innovations[k] = e
        states[k] = x[..., 0]
        corrected = x + Kf @ e[..., None]
        if remembers:
            memory = recall(memory, x, corrected)
        f = forces(corrected, memory, t)
        x = corrected
        for s in range(steps):
            free = A @ x + driven[s][k][..., None]
            if s == steps - 1:
                free += Kw @ e[..., None]
            ahead_of = free + both @ f
            later = recall(memory, x, ahead_of) if remembers else memory
            g = forces(ahead_of, later, t + (s + 1) * h)
            x_next = ahead_of + E1 @ (g - f)
            if remembers:
                memory = recall(memory, x, x_next)
            # the force at the corrected end differs from g by the step's third order
            x, f = x_next, g
        np.clip(x, -1e6, 1e6, out=x)
    return np.moveaxis(innovations, 0, 2), np.moveaxis(states, 0, 2)


def _entered(matrix: Array, u: Array) -> Array:
    """Return matrix u(k) for all samples: (t, v, n, r) and (t, v or 1, k, r) to (k, t, v, n)."""
    return np.moveaxis(np.matmul(u, np.swapaxes(matrix, 2, 3)), 2, 0)
