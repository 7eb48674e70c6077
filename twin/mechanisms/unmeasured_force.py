"""A force that nobody measured: traffic, a fan, wind, a table that shakes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from scipy.linalg import block_diag, expm, solve_continuous_lyapunov
from scipy.signal import butter

from twin.mechanisms.mechanism import Array, Disturbance, Surroundings
from twin.mechanisms.scales import rms
from twin.model.port import GROUND
from twin.parameter import Parameter

WIDEST_HZ = 500.0
"""Beyond it a frame's force is white."""


ORDER = 4
"""Of the Butterworth filter that gives a band its edges."""


STROKE_M = 1.0
"""RMS displacement of a base at most: the largest shaking tables have it as their stroke, strong
ground motion reaches it. An acceleration that would move it farther is a sensor's zero."""


EDGED = 0.25
"""Width over frequency of the first guess of a band with edges: a third of an octave."""


@dataclass(frozen=True)
class UnmeasuredForce(Disturbance):
    """A force along a port [N] or an acceleration of the base [m/s^2]: a band of noise.

    It is that of an oscillator, s'' + 2 pi b s' + (2 pi f)^2 s = white noise, with b to zero for a
    sinusoid, or a band from f - b/2 to f + b/2 with steep edges (Butterworth).

    Attributes:
        edged: 1 for the band with edges, 0 for the oscillator's.

    Source: latent forces as state spaces, Hartikainen and Sarkka 2011.
    """

    name: ClassVar[str] = "unmeasured_force"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "motion"
    parameters: ClassVar = {
        "rms": Parameter("N, at the ground m/s^2", "standard deviation", "log"),
        "frequency": Parameter("Hz", "about which it lies", "log"),
        "bandwidth": Parameter("Hz", "how broad it lies; to zero for a sinusoid", "log"),
    }
    reference: ClassVar[str] = "Hartikainen and Sarkka 2011; Rogers and Friis 2022"
    valleys: ClassVar[int] = 8  # one at every frequency, with and without edges
    mjcf: ClassVar[str] = "a disturbance is not part of the model"

    rms: float = 0.0
    frequency: float = 1.0
    bandwidth: float = 1.0
    edged: float = 0.0

    @classmethod
    def units(cls, port_unit: str) -> dict[str, str]:
        """Return each parameter's unit at a port in "m" or "rad", or at a base in "m/s^2"."""
        strength = {"m": "N", "rad": "N m", "m/s^2": "m/s^2"}[port_unit]
        return {"rms": strength, "frequency": "Hz", "bandwidth": "Hz"}

    def forms(self) -> tuple[Self, ...]:
        """Return it as an oscillator's and with edges."""
        return replace(self, edged=0.0), replace(self, edged=1.0)

    def oscillator(self) -> tuple[float, float, float]:
        """Return frequency [Hz], bandwidth [Hz] and rms [N, or m/s^2 at the ground]."""
        # a bandwidth of nothing has no stationary filter; this one rings for hours
        width = min(max(self.bandwidth, 1e-4 * self.frequency), WIDEST_HZ)
        frequency, size = min(self.frequency, WIDEST_HZ), self.rms
        if _is_base(self.place):
            size /= np.hypot(1.0, size / (STROKE_M * (2 * np.pi * frequency) ** 2))
        return frequency, width, size

    def shaping(self) -> tuple[Array, Array, Array]:
        """Return the filter that makes the force from white noise of unit intensity."""
        f, width, rms_ = self.oscillator()
        if not self.edged:
            return oscillator_shaping(f, width, rms_)
        A, b, c = _band(max(f - width / 2, 0.1 * f), f + width / 2)
        P = solve_continuous_lyapunov(A, -np.outer(b, b))
        return A, b * rms_ / np.sqrt(c @ P @ c), c

    def realisation(self, samples: int, rate_hz: float, rng: np.random.Generator) -> Array:
        """Return one history of it, stationary from the first sample, (samples,)."""
        block, b, c = self.shaping()
        A = expm(block / rate_hz)
        stationary = solve_continuous_lyapunov(block, -np.outer(b, b))
        values, vectors = np.linalg.eigh(stationary - A @ stationary @ A.T)
        noise = rng.standard_normal((samples, len(b))) * np.sqrt(np.maximum(values, 0)) @ vectors.T
        first, turned = np.linalg.eigh(stationary)
        state = turned @ (np.sqrt(np.maximum(first, 0)) * rng.standard_normal(len(b)))
        out = np.empty(samples)
        for n in range(samples):
            out[n] = c @ state
            state = A @ state + noise[n]
        return out

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return broad bands, and narrow bands at, between and around the frame's frequencies.

        Where a spectrum has steep edges, an oscillator's shape takes it for a force elsewhere.
        """
        own = np.sort(np.asarray(around.natural_frequencies, float))
        middle = float(np.sqrt(own[0] * own[-1])) if len(own) else 1.0
        scale = 0.02 * around.stiffness * rms(around.drift)
        if _is_base(place):
            scale /= max(around.mass_above, 1e-9)
        lines = [*around.peaks, *own[:4], *np.sqrt(own[1:] * own[:-1])[:3]]
        widths = [(f, 0.002 * f) for f in around.peaks] + [(f, 0.02 * f) for f in lines]
        narrow = (cls(place, scale, float(f), float(width)) for f, width in widths)
        edged = (cls(place, scale, float(f), EDGED * float(f), 1.0) for f in around.peaks[:2])
        broad = (cls(place, scale, middle, 2 * middle, edges) for edges in (0.0, 1.0))
        return (*broad, *narrow, *edged)


def oscillator_shaping(frequency: float, width: float, size: float) -> tuple[Array, Array, Array]:
    """Return block (2, 2), drive (2,) and shape (2,) of s'' + 2 pi b s' + (2 pi f)^2 s = noise.

    Args:
        frequency: f [Hz].
        width: b [Hz].
        size: RMS of s.
    """
    a, square = 2 * np.pi * width, (2 * np.pi * frequency) ** 2
    # the stationary variance of s is q / (2 a w^2)
    drive = np.array([0.0, size * np.sqrt(2 * a * square)])
    return np.array([[0.0, 1.0], [-square, -a]]), drive, np.array([1.0, 0.0])


def _is_base(place: str) -> bool:
    return place == GROUND or place.rpartition(".")[0] == GROUND


def _band(low: float, high: float) -> tuple[Array, Array, Array]:
    """Return a band pass [Hz] from its modes side by side: no high powers of frequencies."""
    corners = 2 * np.pi * np.array([low, high])
    zeros, poles, factor = butter(ORDER, corners, btype="bandpass", analog=True, output="zpk")
    blocks, c = [], []
    for i in np.flatnonzero(poles.imag > 0):
        pole, others = poles[i], np.delete(poles, i)
        residue = factor * np.prod(pole - zeros) / np.prod(pole - others)
        blocks.append([[pole.real, -pole.imag], [pole.imag, pole.real]])
        c += [2 * residue.real, -2 * residue.imag]
    b = np.tile([1.0, 0.0], len(blocks))
    return block_diag(*blocks), b, np.array(c) / np.abs(c).max()
