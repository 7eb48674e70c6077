"""A force that nobody measured: traffic, a fan, wind, a table that shakes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from scipy.linalg import expm

from twin.parameter import Parameter
from twin.physics.mechanism import Array, Disturbance, Surroundings
from twin.physics.scales import rms

WIDEST_HZ = 500.0
"""Beyond it a frame's force is white."""


@dataclass(frozen=True)
class UnmeasuredForce(Disturbance):
    """A force on a floor [N] or an acceleration of the ground [m/s^2], an oscillator under noise.

    Source: latent forces as state spaces, Hartikainen and Sarkka 2011.
    """

    name: ClassVar[str] = "unmeasured_force"
    verdict: ClassVar = "missing_physics"
    where: ClassVar = "floor"
    parameters: ClassVar = {
        "rms": Parameter("N, at the ground m/s^2", "standard deviation", "log"),
        "frequency": Parameter("Hz", "about which it lies", "log"),
        "bandwidth": Parameter("Hz", "how broad it lies; to zero for a sinusoid", "log"),
    }
    reference: ClassVar[str] = "Hartikainen and Sarkka 2011; Rogers and Friis 2022"
    mjcf: ClassVar[str] = "a disturbance is not part of the model"

    rms: float = 0.0
    frequency: float = 1.0
    bandwidth: float = 1.0

    def oscillator(self) -> tuple[float, float, float]:
        """Return frequency [Hz], bandwidth [Hz] and rms [N, or m/s^2 at the ground]."""
        # a bandwidth of nothing has no stationary filter; this one rings for hours
        width = min(max(self.bandwidth, 1e-4 * self.frequency), WIDEST_HZ)
        return min(self.frequency, WIDEST_HZ), width, self.rms

    def realisation(self, samples: int, rate_hz: float, rng: np.random.Generator) -> Array:
        """Return one history of it, stationary from the first sample, (samples,)."""
        omega, decay = 2 * np.pi * self.frequency, 2 * np.pi * self.bandwidth
        A = expm(np.array([[0.0, 1.0], [-(omega**2), -decay]]) / rate_hz)
        stationary = np.diag([1.0, omega**2])
        values, vectors = np.linalg.eigh(stationary - A @ stationary @ A.T)
        noise = rng.standard_normal((samples, 2)) * np.sqrt(np.maximum(values, 0)) @ vectors.T
        states = np.empty((samples, 2))
        state = np.sqrt(np.diag(stationary)) * rng.standard_normal(2)
        for n in range(samples):
            states[n] = state
            state = A @ state + noise[n]
        return self.rms * states[:, 0]

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return a broad band, and narrow bands at, between and around the frame's frequencies."""
        own = np.sort(np.asarray(around.natural_frequencies, float))
        middle = float(np.sqrt(own[0] * own[-1])) if len(own) else 1.0
        scale = 0.02 * around.stiffness * rms(around.drift)
        if place == "ground":
            scale /= max(around.mass_above, 1e-9)
        lines = [*around.peaks, *own[:4], *np.sqrt(own[1:] * own[:-1])[:3]]
        widths = [(f, 0.002 * f) for f in around.peaks] + [(f, 0.02 * f) for f in lines]
        narrow = (cls(place, scale, float(f), float(width)) for f, width in widths)
        return (cls(place, scale, middle, 2 * middle), *narrow)
