"""How much likelier the truth is than what a rival can make of it, in nats.

Along the true motion every law is a force, and the frame is linear but for it: what a law adds to
the outputs is the frame's response to that force, exactly. What a rival with free strengths makes
of the true change is then a regression of outputs on outputs, and half of what it leaves, in units
of the noise, is the logarithm of the likelihood ratio, to first order in what is left. The noise is
that of the outputs and of the measured input, which reaches the outputs through the frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from .plans import FINE_HZ, SAMPLING_HZ
from .rehearsal import COARSE, Rehearsal
from .rig import Array
from .whitener import Whitener, noise_path

Spectrum = NDArray[np.complex128]

RATE = FINE_HZ / COARSE
STRIDE = round(RATE / SAMPLING_HZ)
RINGING_S = 25.0
"""Silence after a recording, in which the frame's response comes to rest."""

SMALLEST = 1e-9
"""A rival's column that is shorter than this share of itself after the others adds nothing."""


@dataclass(frozen=True)
class _Recorded:
    """What a test's whitening needs.

    Attributes:
        samples: on the coarse grid.
        padded: the same with the silence after it.
        transfer: accelerations seen from the ground, per force, (frequencies, floors, floors).
        whitener: undoes the noise's covariance.
    """

    samples: int
    padded: int
    transfer: Spectrum
    whitener: Whitener


class Likelihood:
    """The training recordings of a case as a space in which the noise has unit variance."""

    def __init__(self, rehearsal: Rehearsal) -> None:
        """Prepare for a rehearsal's rig, tests and noise."""
        self.rehearsal = rehearsal
        self.channels = np.array(rehearsal.recorded) - 1
        self._tests = tuple(self._prepared(i) for i in range(len(rehearsal.tests)))

    def response(self, test: int, forces: Array) -> Array:
        """Return the floors' accelerations from forces on them, both (samples, floors)."""
        one = self._tests[test]
        spectrum = rfft(forces, one.padded, axis=0)
        moved = np.einsum("fij,fj->fi", one.transfer, spectrum)
        return np.asarray(irfft(moved, one.padded, axis=0)[: one.samples])

    def whitened(self, outputs: Sequence[Array]) -> Array:
        """Return the recorded floors' outputs of all tests, (samples, floors), as one vector."""
        parts = []
        for one, output in zip(self._tests, outputs, strict=True):
            parts.append(one.whitener.of(output[::STRIDE, self.channels]).ravel())
        return np.concatenate(parts)

    def _prepared(self, i: int) -> _Recorded:
        r = self.rehearsal
        test, (seen, _) = r.tests[i], r.healthy[i]
        padded = next_fast_len(len(seen) + round(RINGING_S * RATE), real=True)
        transfer = self._transfer(np.fft.rfftfreq(padded, 1 / RATE))
        sampled = seen[::STRIDE, self.channels]
        noise = r.chain.noise
        driven = noise * float(np.sqrt(np.mean(r.drives[i] ** 2)))
        own = noise * np.sqrt(np.mean(sampled**2, axis=0))
        system = noise_path(r.rig, test.floor, self.channels, 1 / SAMPLING_HZ)
        whitener = Whitener.of_noise(*system, driven, own, len(sampled))
        return _Recorded(len(seen), padded, transfer, whitener)

    def _transfer(self, frequency: Array) -> Spectrum:
        rig = self.rehearsal.rig
        omega, shapes = rig.modes
        s = 2j * np.pi * frequency[:, None]
        modal = s**2 / (s**2 + 2 * s * np.array(rig.damping_ratios) * omega + omega**2)
        return np.asarray(np.einsum("im,fm,jm->fij", shapes, modal, shapes))


class Left:
    """What rivals leave of a vector, their columns taken out one after the other."""

    def __init__(self, columns: Sequence[Array]) -> None:
        """Make an orthonormal basis of the columns."""
        unit = [c / np.linalg.norm(c) for c in columns if np.linalg.norm(c) > 0]
        basis, upper = np.linalg.qr(np.column_stack(unit))
        self._basis = basis[:, np.abs(np.diag(upper)) > SMALLEST]

    def of(self, vector: Array) -> Array:
        """Return what is left of a vector."""
        return np.asarray(vector - self._basis @ (self._basis.T @ vector))


def nats(left: Array) -> float:
    """Return half the squared length."""
    return float(left @ left / 2)
