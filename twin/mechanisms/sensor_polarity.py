"""A sensor that is mounted the wrong way round."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from twin.mechanisms.instrument import Instrument
from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings


@dataclass(frozen=True)
class SensorPolarity(ChannelFault):
    """Recorded = -true.

    Source: ISO 5348, mounting of accelerometers.
    """

    name: ClassVar[str] = "sensor_polarity"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    parameters: ClassVar = {}
    reference: ClassVar[str] = "ISO 5348"
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"

    def scaled(self, factor: float) -> Self:
        """Return the fault as it is: there is no more or less of it."""
        return self

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels with the sign turned."""
        return self._change(columns, np.negative)

    def undo(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels with the sign turned back."""
        return self._change(columns, np.negative)

    def instrument(self, rms: float) -> Instrument:
        """Return the sign."""
        return Instrument.static(np.array([[-1.0]]))

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return the one there is."""
        return (cls(place),)
