"""A channel whose zero wanders: an amplifier that warms up, a cable that is moved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from twin.mechanisms.instrument import Instrument
from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.mechanisms.scales import rms
from twin.parameter import Parameter


@dataclass(frozen=True)
class SensorDrift(ChannelFault):
    """Recorded = true + b, b' = rate w: the zero walks at random; it starts anywhere.

    Attributes:
        seed: of the walk where it is simulated; not fitted.

    Source: IEEE 1554 and 952, random walk of an inertial sensor's bias.
    """

    name: ClassVar[str] = "sensor_drift"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    parameters: ClassVar = {
        "rate": Parameter("the channel's/s^0.5", "what the zero wanders by in a second", "log")
    }
    reference: ClassVar[str] = "IEEE 952, Allan variance"
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"

    rate: float = 0.0
    seed: float = 0.0

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels with one history of the walk, from zero."""
        if not self.rate:
            return self._change(columns, np.copy)
        rng = np.random.default_rng(int(self.seed))

        def wandering(x: Array) -> Array:
            steps = rng.standard_normal(len(x)) * self.rate / np.sqrt(rate_hz)
            return x + np.cumsum(steps) - steps[0]

        return self._change(columns, wandering)

    def instrument(self, rms: float) -> Instrument:
        """Return the zero as a state that starts within the reading's RMS."""
        none = np.zeros(1)
        start, drive = np.array([[rms**2]]), np.array([self.rate])
        return Instrument.of(np.zeros((1, 1)), none, np.ones(1), 1.0, start, drive)

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return walks that come to a hundredth to all of the reading's RMS over a recording."""
        whole = rms(around.reading) / max(around.duration_s, 1e-9) ** 0.5
        return tuple(cls(place, share * whole) for share in (0.01, 0.1, 1.0))
