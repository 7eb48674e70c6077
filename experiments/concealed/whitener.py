"""The noise of a recording, made white: that of the outputs, and that of the measured input.

The input's noise rings in the frame for longer than a short recording lasts, so spectra of the
recording's length do not resolve it. A Kalman filter of the frame does (Anderson and Moore 1979,
ch. 9): from rest, its innovations over the root of their covariance are the recording times the
inverse root of the noise's covariance, exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.signal import cont2discrete

from .rig import Array, Integers, Rig


def noise_path(
    rig: Rig, floor: int, channels: Integers, step_s: float
) -> tuple[Array, Array, Array, Array]:
    """Return x+ = A x + B w, y = C x + D w from the driving channel's noise to the sensors.

    Args:
        rig: the frame.
        floor: that the force acts on, from 1; 0 where the ground is shaken.
        channels: recorded floors, from 0.
        step_s: sampling interval [s]; the noise is a straight line between samples.
    """
    omega, shapes = rig.modes
    n = len(omega)
    push = np.eye(n)[floor - 1] if floor else -np.array(rig.masses)
    A = np.zeros((2 * n, 2 * n))
    A[:n, n:] = np.eye(n)
    A[n:, :n] = -np.diag(omega**2)
    A[n:, n:] = -np.diag(2 * np.array(rig.damping_ratios) * omega)
    B = np.concatenate([np.zeros(n), shapes.T @ push])[:, None]
    C = shapes[channels] @ A[n:]
    D = shapes[channels] @ B[n:] + (0.0 if floor else 1.0)
    found = cont2discrete((A, B, C, D), step_s, method="foh")
    return found[0], found[1], found[2], found[3]


@dataclass(frozen=True)
class Whitener:
    """What makes a recording's noise white.

    Attributes:
        A: of the frame, (n, n).
        C: (m, n).
        gains: of the predictor at each sample, (samples, n, m).
        roots: inverse roots of the innovations' covariances, (samples, m, m).
    """

    A: Array
    C: Array
    gains: Array
    roots: Array

    @classmethod
    def of_noise(
        cls, A: Array, B: Array, C: Array, D: Array, driven: float, own: Array, samples: int
    ) -> Whitener:
        """Return it for white noise of deviation ``driven`` in the input, ``own`` in the sensors.

        Args:
            A: (n, n).
            B: (n, 1).
            C: (m, n).
            D: (m, 1).
            driven: deviation of the input's noise.
            own: of the sensors', (m,).
            samples: of the recording.
        """
        enter, seen = driven * B, driven * D
        covariances = enter @ enter.T, seen @ seen.T + np.diag(own**2), enter @ seen.T
        dense = [np.ascontiguousarray(matrix, float) for matrix in (A, C, *covariances)]
        gains, roots = _riccati(*dense, samples)
        return cls(dense[0], dense[1], gains, roots)

    def of(self, outputs: Array) -> Array:
        """Return outputs (samples, m) in units of the noise, (samples, m)."""
        return np.asarray(_whitened(self.A, self.C, self.gains, self.roots, outputs.copy()))


@njit(cache=True)
def _riccati(A, C, Q, R, S, samples):  # type: ignore[no-untyped-def]
    n, m = len(A), len(C)
    P = np.zeros((n, n))
    gains, roots = np.empty((samples, n, m)), np.empty((samples, m, m))
    for k in range(samples):
        covariance = C @ P @ C.T + R
        K = (A @ P @ C.T + S) @ np.linalg.inv(covariance)
        gains[k] = K
        roots[k] = np.linalg.inv(np.linalg.cholesky(covariance))
        P = A @ P @ A.T + Q - K @ covariance @ K.T
        P = (P + P.T) / 2
    return gains, roots


@njit(cache=True)
def _whitened(A, C, gains, roots, y):  # type: ignore[no-untyped-def]
    n, m = len(A), len(C)
    x, new, e = np.zeros(n), np.zeros(n), np.zeros(m)
    for k in range(len(y)):
        for o in range(m):
            e[o] = y[k, o]
            for i in range(n):
                e[o] -= C[o, i] * x[i]
        for i in range(n):
            new[i] = 0.0
            for j in range(n):
                new[i] += A[i, j] * x[j]
            for o in range(m):
                new[i] += gains[k, i, o] * e[o]
        for o in range(m):
            y[k, o] = 0.0
            for i in range(o + 1):
                y[k, o] += roots[k, o, i] * e[i]
        x[:] = new
    return y
