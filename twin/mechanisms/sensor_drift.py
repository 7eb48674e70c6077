"""A channel whose zero wanders: an amplifier that warms up, a cable that is moved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from scipy.linalg import expm

from twin.estimation.system import noise_integral
from twin.mechanisms.instrument import Instrument
from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.mechanisms.scales import rms
from twin.parameter import Parameter

WALK, FLICKER, RAMP = 0.0, 1.0, 2.0
"""The forms that IEEE 952 tells apart by their Allan variance, beside white noise: rate random
walk, bias instability and rate ramp."""

CORNERS_HZ = (0.01, 0.1, 1.0, 10.0, 100.0)
"""Of first-order processes of one variance, whose spectra add up to 1/f: one a decade keeps within
a tenth of it from 0.03 to 30 Hz (Keshner 1982)."""

SECOND_S = 1.0
"""Time in which a zero, or the slope of a ramp, wanders by the rate."""


@dataclass(frozen=True)
class SensorDrift(ChannelFault):
    """Recorded = true + b: the zero walks at random, flickers, or is a ramp that bends.

    A walk is b' = rate w and starts anywhere; a ramp is b'' = rate w / 1 s, and starts anywhere
    with any slope; a flicker has a spectrum of 1/f, and rate 1 s^0.5 as standard deviation in each
    decade.

    Attributes:
        form: 0 for a walk, 1 for a flicker, 2 for a ramp.
        seed: of its history where it is simulated; not fitted.

    Source: IEEE 952 and 1554, errors of an inertial sensor's bias; Keshner 1982, 1/f noise.
    """

    name: ClassVar[str] = "sensor_drift"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    parameters: ClassVar = {
        "rate": Parameter("the channel's/s^0.5", "what the zero wanders by in a second", "log")
    }
    reference: ClassVar[str] = "IEEE 952, Allan variance"
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"

    ranged: ClassVar[bool] = True

    rate: float = 0.0
    seed: float = 0.0
    form: float = WALK

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels with one history of it; walk and ramp begin at zero."""
        if not self.rate:
            return self._change(columns, np.copy)
        rng = np.random.default_rng(int(self.seed))
        return self._change(columns, lambda x: x + self._history(len(x), 1 / rate_hz, rng))

    def instrument(self, rms: float) -> Instrument:
        """Return the zero as states that start within the reading's RMS."""
        if self.form == FLICKER:
            corners, size = 2 * np.pi * np.array(CORNERS_HZ), self.rate * SECOND_S**0.5
            drive, start = np.diag(size * np.sqrt(2 * corners)), size**2 * np.eye(len(corners))
            return _added(-np.diag(corners), np.ones(len(corners)), drive, start)
        if self.form == RAMP:
            slope = rms / SECOND_S  # a zero that moves by all of its reading in a second is none
            drive = np.array([[0.0], [self.rate / SECOND_S]])
            return _added(np.eye(2, k=1), np.array([1.0, 0.0]), drive,
                          np.diag([rms**2, slope**2]))  # fmt: skip
        return _added(np.zeros((1, 1)), np.ones(1), np.array([[self.rate]]), np.array([[rms**2]]))

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return drifts that come to a hundredth to all of the reading's RMS over a recording."""
        whole, long = rms(around.reading), max(around.duration_s, 1e-9)
        rates = {
            WALK: whole / long**0.5,
            FLICKER: whole / SECOND_S**0.5,
            RAMP: whole * SECOND_S * (3 / long**3) ** 0.5,
        }
        return tuple(
            cls(place, share * rate, form=form)
            for form, rate in rates.items()
            for share in (0.01, 0.1, 1.0)
        )

    def _history(self, samples: int, step_s: float, rng: np.random.Generator) -> Array:
        """Return one history, (samples,)."""
        made = self.instrument(0.0)
        A, k = expm(made.A * step_s), len(made.A)
        noise = _root(noise_integral(made.A, made.G, step_s))
        state, out = _root(made.start) @ rng.standard_normal(k), np.empty(samples)
        for n, white in enumerate(rng.standard_normal((samples, k))):
            out[n] = made.C[0] @ state
            state = A @ state + noise @ white
        return out


def _added(A: Array, C: Array, G: Array, start: Array) -> Instrument:
    """Return an instrument that adds what its own states are."""
    k = len(A)
    return Instrument(np.ones((1, 1)), A, np.zeros((k, 1)), C[None], G, start)


def _root(covariance: Array) -> Array:
    values, vectors = np.linalg.eigh((covariance + covariance.T) / 2)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0)))
