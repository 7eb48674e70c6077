"""Derivatives of a stationary filter, and of what its first state tells, by the unknowns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.estimation.first_state import Settled, after
from twin.estimation.kalman import EquivalentLinear, linear_of
from twin.estimation.riccati import DOUBLINGS, summed
from twin.estimation.system import Noise, Sampled

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SettledSlopes:
    """Derivatives of a stationary filter with respect to k unknowns, these in the last axis.

    Attributes:
        gain: of state and held disturbances, (n + w, m, k).
        innovation: of the innovations' covariance, (m, m, k).
        odds: of what the Gramian and the prior add to the log likelihood, (k,).
        spread: of D, (n, n, k).
    """

    gain: Array
    innovation: Array
    odds: Array
    spread: Array


def settled_slopes(
    here: Settled,
    systems: Sequence[tuple[Sampled, Noise]],
    steps: Array,
    noise: Noise,
    equivalent: EquivalentLinear | None = None,
) -> SettledSlopes:
    """Return how a stationary filter changes from system to system.

    Riccati's equation is differentiated: its gain is optimal, so that

        dP = F dP F^T + (dA - K dC) P F^T + (dW - K dV) (W - K V)^T + (the same)^T + dQ + K dR K^T

    with F = A - K C, and so is that of what a first state tells.

    Args:
        here: the filter.
        systems: k systems a step away, with their noise.
        steps: of each, (k,).
        noise: of the filter itself.
        equivalent: what laws add to each of them, if there are laws.
    """
    A, C, W, V, _, _ = here.linear
    S, P = here.gain.innovation[-1], here.gain.predicted
    state = here.gain.state[-1]
    inverse = np.linalg.inv(S)
    held = V.T @ inverse
    K, F = A @ state + W @ held, here.closed
    moved = [linear_of(plant, own, equivalent) for plant, own in systems]
    dA, dC, dW, dV, dQ, dR = (
        (np.stack(near) - base) / np.reshape(steps, (-1, 1, 1))
        for near, base in zip(zip(*moved, strict=True), here.linear, strict=True)
    )
    pairs = [(here.linear, noise), *zip(moved, [own for _, own in systems], strict=True)]
    starts = after(
        np.stack([of[0] for of, _ in pairs]),
        np.stack([of[2] @ of[2].T + of[4] for of, _ in pairs]),
        np.stack([own.start for _, own in pairs]),
        here.first,
    )
    dstart = (starts[1:] - starts[0]) / np.reshape(steps, (-1, 1, 1))
    dlevel = np.stack([own.held - noise.held for _, own in systems]) / np.reshape(steps, (-1, 1))
    half = (dA - K @ dC) @ (P @ F.T) + (dW - K @ dV) @ (W - K @ V).T
    dP = summed(F, half + half.swapaxes(1, 2) + dQ + K @ dR @ K.T, 2**DOUBLINGS)
    half = dC @ (P @ C.T) + dV @ V.T
    dS = half + half.swapaxes(1, 2) + C @ dP @ C.T + dR
    dstate = (dP @ C.T + P @ dC.swapaxes(1, 2) - state @ dS) @ inverse
    dheld = (dV.swapaxes(1, 2) - held @ dS) @ inverse
    dK = dA @ state + A @ dstate + dW @ held + W @ dheld
    dF = dA - dK @ C - K @ dC
    of_F, of_C, of_S = _of_told(here, C, inverse)
    wide, G = dstart - dP, here.gramian
    traced = sum(np.einsum("ij,kij->k", of, d)
                 for of, d in ((of_F, dF), (of_C, dC), (of_S, dS)))  # fmt: skip
    traced = traced + np.einsum("ij,kij->k", G - G @ here.posterior @ G, wide)
    level = noise.held[:, None]
    dgain = np.concatenate([dstate, level * dheld + dlevel[:, :, None] * held], axis=1)
    gain, innovation, spread = (np.moveaxis(d, 0, -1) for d in (dgain, dS, wide))
    return SettledSlopes(gain, innovation, -0.5 * traced, spread)


def _of_told(here: Settled, C: Array, inverse: Array) -> tuple[Array, Array, Array]:
    """Return slopes of tr (N G), N as it is, by F = A - K C, C and S, (n, n), (m, n), (m, m).

    G is the sum over the samples that there are, that over any number of them less that over those
    later; that outputs may be more uncertain at times is left out.
    """
    F, N, n = here.closed, here.posterior, len(here.closed)
    every, Z = summed(F.T, C.T @ inverse @ C, 2**DOUBLINGS), summed(F, N, here.samples)
    with np.errstate(all="ignore"):
        last = np.linalg.matrix_power(F, here.samples)
        block = np.block([[F.T, every @ last @ N], [np.zeros((n, n)), F.T]])
        late = np.linalg.matrix_power(block, here.samples)[:n, n:]
    seen = inverse @ C
    return 2 * (every @ F @ Z - late), 2 * seen @ Z, -seen @ Z @ seen.T
