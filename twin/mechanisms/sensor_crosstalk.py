"""Two channels of which each hears the other: cables side by side, a multiplexer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from twin.errors import ModelError, available
from twin.mechanisms.instrument import Instrument
from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.parameter import Parameter


@dataclass(frozen=True)
class SensorCrosstalk(ChannelFault):
    """Recorded a = a + first b, recorded b = b + second a; the place is "acc_floor1+acc_floor2".

    Source: IEC 60268-3, crosstalk attenuation between channels.
    """

    name: ClassVar[str] = "sensor_crosstalk"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channels"
    parameters: ClassVar = {
        "first": Parameter("1", "share of the second channel in the first"),
        "second": Parameter("1", "share of the first channel in the second"),
    }
    reference: ClassVar[str] = "IEC 60268-3"
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"

    first: float = 0.0
    second: float = 0.0

    def priors(self) -> dict[str, tuple[float, float]]:
        """A tenth is much."""
        return dict.fromkeys(self.parameters, (0.0, 0.05))

    def scaled(self, factor: float) -> Self:
        """Return ``factor`` times as much of either in the other."""
        return self._times(factor, "first", "second")

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels, mixed."""
        return self._mixed(columns, self._matrix())

    def undo(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels, taken apart."""
        return self._mixed(columns, np.asarray(np.linalg.inv(self._matrix()), float))

    def instrument(self, rms: float) -> Instrument:
        """Return the mixture."""
        return Instrument.static(self._matrix())

    def _matrix(self) -> Array:
        return np.array([[1.0, self.first], [self.second, 1.0]])

    def _mixed(self, columns: Mapping[str, Array], matrix: Array) -> dict[str, Array]:
        if len(self.channels) != 2 or not set(self.channels) <= set(columns):
            raise ModelError(
                f"'{self.place}' are no two channels, name+name; there are {available(columns)}"
            )
        a, b = (columns[name] for name in self.channels)
        mixed = [row[0] * a + row[1] * b for row in matrix]
        return {**columns, **dict(zip(self.channels, mixed, strict=True))}

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return some hundredths, both ways alike."""
        return tuple(cls(place, share, share) for share in (0.02, -0.02, 0.1, -0.1))
