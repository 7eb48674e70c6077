"""A sensor that rings on its mounting: wax, a magnet, a loose stud."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from twin.mechanisms.instrument import Instrument
from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.mechanisms.shifting import through
from twin.parameter import Parameter

DECAYED = 10.0
"""Time constants after which an oscillation is forgotten: exp(-10) is 5e-5."""


@dataclass(frozen=True)
class SensorResonance(ChannelFault):
    """Recorded = (2 damping_ratio w s + w^2) / (s^2 + 2 damping_ratio w s + w^2) true.

    With w = 2 pi frequency: what a sensor moves by that a spring and a dashpot hold to the
    structure.

    Source: ISO 5348, mounted resonance of an accelerometer; Den Hartog 1934, transmissibility.
    """

    name: ClassVar[str] = "sensor_resonance"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    parameters: ClassVar = {
        "frequency": Parameter("Hz", "at which the sensor rings on its mounting", "log"),
        "damping_ratio": Parameter("1", "of that ringing", "log"),
    }
    reference: ClassVar[str] = "ISO 5348"
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"
    shifts_resonance: ClassVar[bool] = True

    frequency: float = np.inf
    damping_ratio: float = 0.05

    def scaled(self, factor: float) -> Self:
        """Return a mounting ``factor`` times as compliant."""
        return self._times(factor**-0.5, "frequency")

    def priors(self) -> dict[str, tuple[float, float]]:
        """Mountings are lightly damped."""
        return {"damping_ratio": (float(np.log(0.05)), 1.0)}

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels as they ring, without the transient of a start."""
        if not np.isfinite(self.frequency):
            return self._change(columns, np.copy)
        reach = DECAYED / (2 * np.pi * self.frequency * max(self.damping_ratio, 1e-3))
        return self._change(columns, lambda x: through(x, self._response, rate_hz, reach))

    def instrument(self, rms: float) -> Instrument:
        """Return the oscillator whose motion is read."""
        w = 2 * np.pi * self.frequency
        dashpot = 2 * self.damping_ratio * w
        A = np.array([[-dashpot, 1.0], [-(w**2), 0.0]])
        start = np.diag([rms**2, (w * rms) ** 2])
        return Instrument.of(A, np.array([dashpot, w**2]), np.array([1.0, 0.0]), 0.0, start)

    def _response(self, frequency: Array) -> NDArray[np.complex128]:
        r = frequency / self.frequency
        dashpot = 2j * self.damping_ratio * r
        return np.asarray((1 + dashpot) / (1 - r**2 + dashpot))

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return mountings from a quarter of the band of the recording to twice it.

        And at what is unexplained: a light one rings in a narrow band, which others do not meet.
        """
        half = around.sampling_hz / 2
        wide = (share * half for share in (0.25, 0.4, 0.6, 0.9, 1.3, 2.0))
        return tuple(cls(place, f) for f in (*wide, *around.peaks))
