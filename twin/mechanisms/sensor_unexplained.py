"""A channel with an error of its own that has no name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from scipy.signal import lfilter

from twin.mechanisms.instrument import Instrument
from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.mechanisms.scales import rms
from twin.parameter import Parameter


@dataclass(frozen=True)
class SensorUnexplained(ChannelFault):
    """Recorded = true + e, e' = -2 pi frequency e + noise: an error that only one channel has.

    Attributes:
        seed: of its history where it is simulated; not fitted.

    Source: Uhlenbeck and Ornstein 1930; as a latent process, Hartikainen and Sarkka 2011.
    """

    name: ClassVar[str] = "sensor_unexplained"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    generic: ClassVar[bool] = True
    parameters: ClassVar = {
        "rms": Parameter("the channel's", "standard deviation", "log"),
        "frequency": Parameter("Hz", "up to which it lies", "log"),
    }
    fields_of: ClassVar = {"rms": "strength"}
    reference: ClassVar[str] = "Uhlenbeck and Ornstein 1930; Hartikainen and Sarkka 2011"
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"

    strength: float = 0.0
    frequency: float = 1.0
    seed: float = 0.0

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels with one stationary history of it."""
        if not self.strength:
            return self._change(columns, np.copy)
        rng = np.random.default_rng(int(self.seed))
        kept = np.exp(-2 * np.pi * self.frequency / rate_hz)

        def erring(x: Array) -> Array:
            drive = rng.standard_normal(len(x)) * np.sqrt(1 - kept**2)
            drive[0] /= np.sqrt(1 - kept**2)
            return np.asarray(x + self.strength * lfilter([1.0], [1.0, -kept], drive))

        return self._change(columns, erring)

    def instrument(self, rms: float) -> Instrument:
        """Return the error as a stationary state."""
        rate = 2 * np.pi * self.frequency
        return Instrument.of(
            np.array([[-rate]]),
            np.zeros(1),
            np.ones(1),
            1.0,
            np.array([[self.strength**2]]),
            np.array([self.strength * np.sqrt(2 * rate)]),
        )

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return slow and quick errors of a hundredth and a tenth of the reading."""
        first = min(around.natural_frequencies, default=1.0)
        scale = rms(around.reading)
        return tuple(
            cls(place, share * scale, part * first) for share in (0.01, 0.1) for part in (0.1, 3.0)
        )
