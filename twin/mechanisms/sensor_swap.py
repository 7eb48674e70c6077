"""Two cables that were exchanged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from twin.errors import ModelError, available
from twin.mechanisms.instrument import Instrument
from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings


@dataclass(frozen=True)
class SensorSwap(ChannelFault):
    """Each of two channels carries the other's signal; the place is "acc_floor1+acc_floor2".

    Source: ISO 5348, mounting of accelerometers.
    """

    name: ClassVar[str] = "sensor_swap"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channels"
    parameters: ClassVar = {}
    reference: ClassVar[str] = "ISO 5348"
    of_kinds: ClassVar[frozenset[str]] = frozenset({"acc"})
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"

    def scaled(self, factor: float) -> Self:
        """Return the fault as it is: there is no more or less of it."""
        return self

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels, exchanged."""
        if len(self.channels) != 2 or not set(self.channels) <= set(columns):
            raise ModelError(
                f"'{self.place}' are no two channels, name+name; there are {available(columns)}"
            )
        first, second = self.channels
        return {**columns, first: columns[second], second: columns[first]}

    def undo(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels, exchanged back."""
        return self.distort(columns, rate_hz)

    def instrument(self, rms: float) -> Instrument:
        """Return the exchange."""
        return Instrument.static(np.array([[0.0, 1.0], [1.0, 0.0]]))

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return the one there is."""
        return (cls(place),)
