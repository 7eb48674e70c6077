"""What modes above half the sampling rate do to outputs when a law's force drives them.

The predictor steps such modes from sample to sample strongly damped, as they would else ring at
corners that no true force has. A law with corners does stir them: its force f, simulated, moves a
mode q'' + r q' + w^2 q = f as it is, and through the analyser's filter h an output shows h*q. That
is the exact answer of the mode to the filtered force, and what the predictor has of it is known.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len

from twin.estimation.low_pass import MOMENTS, REACH, TO_POWERS, around

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

SILENCE = 2
"""How many times as long a signal is taken for, so that nothing comes round of fast modes."""


@dataclass(frozen=True)
class Ringing:
    """Modes above half the sampling rate.

    Attributes:
        square, rate: w^2 and r of each, (k,).
        stepped: r of each as the predictor steps it, (k,).
        entry: force of each law on each, over its mass, (k, l).
        seen: how outputs see displacements, velocities and accelerations, (3, m, k).
    """

    square: Array
    rate: Array
    stepped: Array
    entry: Array
    seen: Array

    def beyond(self, forces: Array, more: Array, shown: Array, steps: int, step_s: float) -> Array:
        """Return what outputs show beyond what the predictor has of these modes, (samples, m, q).

        Args:
            forces: of the laws over the parts of the samples, (parts, l, q).
            more: what drives the predictor: of each law's filtered force the value at a sample, and
                the Legendre coefficients until the next one, (samples, (1 + MOMENTS) l, q).
            shown: weights of the moments of the forces around a sample in the filtered one at the
                sample and half a sample later, (2, taps).
            steps: parts of a sample.
            step_s: sampling interval [s].
        """
        # what acts at one port acts as one force
        forces, more = self._ports[1] @ forces, np.kron(np.eye(1 + MOMENTS), self._ports[1]) @ more
        samples, laws = len(more), forces.shape[1]
        begin = 2 * REACH  # what acts before the first sample acts from REACH samples before
        length = next_fast_len(SILENCE * (begin + samples), real=True)
        if length not in self._answers:
            self._answers[length] = (
                self._exact(np.arange(length + 1) / length / step_s),
                self._stepped(np.exp(2j * np.pi * np.fft.rfftfreq(length)), step_s),
            )
        exact, found = self._answers[length]
        # the filter leaves nothing beyond the sampling rate: twice as many samples show all of it,
        # and of the outputs every other one is kept: what is above half the rate folds
        flat = np.reshape(forces, (len(forces), -1))
        drive = around(flat[steps - 1], flat, shown, steps, begin + samples, begin)
        drive = drive.reshape(-1, *forces.shape[1:])
        true = exact @ np.fft.rfft(drive, 2 * length, axis=0)
        low = length // 2 + 1
        folded = (true[:low] + np.conj(true[::-1][:low])) / 2
        known = np.concatenate([np.zeros((begin, *more[:, laws:].shape[1:])), more[:, laws:]])
        begun = np.fft.rfft(known, length, axis=0)
        seen = np.fft.irfft(folded - found @ begun, length, axis=0)
        return np.asarray(seen[begin : begin + samples])

    @cached_property
    def _ports(self) -> tuple[Array, Array]:
        """Return the entry of each port, (k, ports), and which laws act there, (ports, laws)."""
        entry, which = np.unique(self.entry, axis=1, return_inverse=True)
        return entry, np.asarray(np.ravel(which) == np.arange(entry.shape[1])[:, None], float)

    @cached_property
    def _answers(self) -> dict[int, tuple[Complex, Complex]]:
        return {}

    def _exact(self, f: Array) -> Complex:
        """Return the outputs' response to forces at frequencies f [Hz], (., m, l)."""
        s = 2j * np.pi * f
        q = 1 / (s[:, None] ** 2 + self.rate * s[:, None] + self.square)
        a = -self.square * q - self.rate * s[:, None] * q
        return np.asarray(
            sum(
                np.einsum("mk,fk,kl->fml", read, answer, self._ports[0], optimize=True)
                for read, answer in zip(self.seen, (q, s[:, None] * q, a), strict=True)
            )
        )

    def _stepped(self, z: Complex, step_s: float) -> Complex:
        """Return the outputs' response to Legendre coefficients, in turn, (., m, MOMENTS l)."""
        half = np.sqrt((self.stepped / 2) ** 2 - self.square + 0j)
        q, v = np.zeros((2, MOMENTS, len(z), len(half)), complex)
        for sign in (1, -1):
            pole = -self.stepped / 2 + sign * half
            over, *powers = between_samples(pole, step_s, MOMENTS)
            states = (TO_POWERS @ powers)[:, None] / (z[:, None] - over)
            states *= sign / (2 * half)
            q, v = q + states, v + pole * states
        a = -self.square * q - self.stepped * v
        response = sum(
            np.einsum("mk,dfk,kl->fmdl", read, answer, self._ports[0], optimize=True)
            for read, answer in zip(self.seen, (q, v, a), strict=True)
        )
        return np.asarray(response).reshape(len(z), self.seen.shape[1], -1)


def between_samples(pole: Any, step_s: float, count: int = 2) -> tuple[Any, ...]:
    """Return e^(p h), and what x' = p x + u makes of each u = (t/h)^k / k! over a sample h.

    Args:
        pole: p [1/s], one or many.
        step_s: h [s].
        count: of the powers, from 0.
    """
    out = [np.exp(pole * step_s)]
    before, factorial = out[0], 1.0
    for k in range(count):
        factorial *= max(k, 1)
        # by parts: what the power before makes, less its end, over p h
        made = (before - (1.0 if k == 0 else step_s / factorial)) / (pole * (step_s if k else 1.0))
        out.append(made)
        before = made
    return tuple(out)
