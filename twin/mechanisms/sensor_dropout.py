"""A channel that stands still for a while: a loose contact, lost packets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.signals.channel_faults import dead_tail, dropouts


@dataclass(frozen=True)
class SensorDropout(ChannelFault):
    """Recorded = the last true reading, from ``begin`` for ``length``; nothing brings them back.

    It is read off the samples, not fitted: what stood still is left out.

    Attributes:
        begin: of the first dropout [s]; not fitted.
        length: of all of them together [s]; not fitted.

    Source: missing observations in a Kalman filter, Jones 1980.
    """

    name: ClassVar[str] = "sensor_dropout"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    parameters: ClassVar = {}
    reference: ClassVar[str] = "Jones 1980, Maximum likelihood fitting with missing observations"
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"
    fitted: ClassVar[bool] = False

    begin: float = 0.0
    length: float = 0.0

    def scaled(self, factor: float) -> Self:
        """Return the fault as it is: it hides what it hides."""
        return self

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels, the reading before the dropout held during it."""

        def standing(x: Array) -> Array:
            out, first = np.array(x, float), round(self.begin * rate_hz)
            out[first : first + round(self.length * rate_hz)] = out[max(first - 1, 0)]
            return out

        return self._change(columns, standing)

    def spoiled(self, reading: Array) -> NDArray[np.bool_]:
        """Return the samples that stand still, to the end of the recording or for a while."""
        hidden = np.zeros(len(reading), bool)
        for fault in (dropouts(reading), dead_tail(reading)):
            if fault is not None:
                hidden |= fault.hides(len(reading))
                hidden[[first for first, _ in fault.samples]] = False  # the one that is repeated
        return hidden

    @classmethod
    def found(cls, place: str, reading: Array, rate_hz: float) -> Self | None:
        """Return the dropouts in a reading, None where there are none."""
        lost = np.flatnonzero(cls(place).spoiled(reading))
        return cls(place, lost[0] / rate_hz, len(lost) / rate_hz) if len(lost) else None

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return the dropouts that there are: none where nothing stands still."""
        found = cls.found(place, around.reading, around.sampling_hz)
        return () if found is None else (found,)
