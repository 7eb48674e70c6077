"""A channel that arrives late: a filter's group delay, a multiplexer, a trigger."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.mechanisms.shifting import later
from twin.parameter import Parameter


@dataclass(frozen=True)
class SensorDelay(ChannelFault):
    """Recorded(t) = true(t - delay); at the record's ends, over the delay, it is a guess.

    Source: sampling theorem, Shannon 1949; fractional delays, Laakso et al. 1996.
    """

    name: ClassVar[str] = "sensor_delay"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    parameters: ClassVar = {"delay": Parameter("s", "of the channel against the others")}
    reference: ClassVar[str] = "Laakso et al. 1996, Splitting the unit delay"
    in_samples: ClassVar[bool] = True
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"
    valleys: ClassVar[int] = 8  # what turns a phase far is no straight line

    delay: float = 0.0

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels with the delay."""
        return self._change(columns, lambda x: later(x, self.delay, rate_hz))

    def moment(self, time: Array) -> Array:
        """Return a time before that of the recording by the delay."""
        return time - self.delay

    def undo(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels without the delay."""
        return self._change(columns, lambda x: later(x, -self.delay, rate_hz))

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return delays and leads, from a fraction of a sample to an eighth of a period."""
        sample = 1 / around.sampling_hz
        quick = max(around.natural_frequencies, default=around.sampling_hz / 10)
        sizes = sorted({0.5 * sample, 2 * sample, 0.03 / quick, 0.12 / quick})
        return tuple(cls(place, sign * size) for size in sizes for sign in (1, -1))
