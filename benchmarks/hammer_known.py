"""A part whose modes are known, hit as the measured one was: same forces, rate, length and noise.

Modes and noise are those that an identification of the measured hits has; numerators are fitted to
the measured responses, so that the known part answers as the measured one does. The force is
interpolated without aliasing to sixteen times the rate and every mode integrated there, exactly
for a force that is linear between those samples: nothing of the identification's own model is used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.identification.records import prepare
from twin.identification.result import Identification
from twin.recording import Recording
from twin.signals.frf import measured_response

Array = NDArray[np.float64]

FINER = 16
"""Steps of the simulation in a sampling interval."""


@dataclass(frozen=True)
class Part:
    """Modes between one force and one accelerometer, and what stands between the two directly.

    Attributes:
        frequency_hz: natural frequencies [Hz].
        damping: damping ratios.
        numerator: a [1/kg] and b [1/(kg s)] of every mode's accelerance
            (a s^2 + b s) / (s^2 + 2 zeta omega s + omega^2), (modes, 2); b is zero for real shapes.
        direct: accelerance of the modes above [1/kg].
            noise: what the identification left of every hit [m/s^2]; noise of the same spectrum is
            added to it.
    """

    frequency_hz: Array
    damping: Array
    numerator: Array
    direct: float
    noise: tuple[Array, ...]

    def damped(self, at_hz: Array, damping: Array) -> Part:
        """Return the part with other damping ratios of the modes nearest to frequencies."""
        changed = self.damping.copy()
        for f, zeta in zip(at_hz, damping, strict=True):
            changed[np.argmin(np.abs(self.frequency_hz - f))] = zeta
        return replace(self, damping=changed)

    def hits(self, forces: Sequence[Array], rate: float, seed: int) -> list[Recording]:
        """Return what each force [N] gives, from rest, with noise."""
        random = np.random.default_rng(seed)
        return [
            Recording.build(
                rate,
                {"force [N]": force,
                 "acc [m/s^2]": self.response(force, rate) + other_phases(left, random)},
                source=f"known part, seed {seed}, hit {number}",
            )
            for number, (force, left) in enumerate(zip(forces, self.noise, strict=True), start=1)
        ]  # fmt: skip

    def response(self, force: Array, rate: float) -> Array:
        """Return the acceleration without noise [m/s^2]."""
        step = 1 / (rate * FINER)
        fine = signal.resample(force, len(force) * FINER)
        acceleration = self.direct * fine
        for f, zeta, (a, b) in zip(self.frequency_hz, self.damping, self.numerator, strict=True):
            w = 2 * np.pi * f
            num, den, _ = signal.cont2discrete(
                ([a, b, 0.0], [1.0, 2 * zeta * w, w**2]), step, "foh"
            )
            acceleration += signal.lfilter(np.ravel(num), den, fine)
        return acceleration[::FINER]


def other_phases(left: Array, random: np.random.Generator) -> Array:
    """Return noise with the amplitude spectrum of a record and random phases."""
    lines = np.abs(np.fft.rfft(left))
    turned = lines * np.exp(2j * np.pi * random.random(len(lines)))
    turned[0] = 0.0
    return np.fft.irfft(turned, len(left))


def like(hits: Sequence[Recording], found: Identification) -> Part:
    """Return a part with the modes found and numerators fitted to the measured responses."""
    f, zeta = found.modal.natural_freq, found.modal.damping_ratio
    records = prepare(hits)
    measured = measured_response(records.pairs, hits[0].sampling_hz)
    inside = (measured.frequency_hz > f.min() / 2) & (measured.frequency_hz < f.max())
    s = 2j * np.pi * measured.frequency_hz[inside, None]
    w = 2 * np.pi * f
    below = s**2 + 2 * zeta * w * s + w**2
    columns = np.hstack([s**2 / below, s * w / below, np.ones_like(s)])
    H = measured.H[inside, 0, 0]
    found_by = np.linalg.lstsq(
        np.vstack([columns.real, columns.imag]), np.r_[H.real, H.imag], rcond=None
    )[0]
    numerator = np.column_stack([found_by[: len(f)], found_by[len(f) : -1] * w])
    left = tuple(np.ravel(y - p) for (_, y), p in zip(records.pairs, found.predicted, strict=True))
    return Part(f, zeta, numerator, float(found_by[-1]), left)


def forces(hits: Sequence[Recording]) -> list[Array]:
    """Return the measured forces, zero outside the hits [N]."""
    return [u[:, 0] for u, _ in prepare(hits).pairs]
