"""A channel whose clock runs fast or slow against the others: a logger of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

from twin.mechanisms.mechanism import INPUTS, OUTPUTS, Array, ChannelFault, Surroundings
from twin.mechanisms.shifting import stretched
from twin.parameter import Parameter

CRYSTAL = 1e-4
"""Standard deviation of a logger's clock: a hundred parts in a million is a cheap crystal."""


@dataclass(frozen=True)
class Clock(ChannelFault):
    """Recorded(t) = true(t (1 + rate)): what a clock gains or loses since the recording began.

    Source: Allan 1987, Time and frequency characterization of precision clocks.
    """

    name: ClassVar[str] = "clock"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    parameters: ClassVar = {"rate": Parameter("1", "share that the channel's clock is slow by")}
    reference: ClassVar[str] = "Allan 1987"
    of_kinds: ClassVar[frozenset[str]] = OUTPUTS | INPUTS
    in_samples: ClassVar[bool] = True
    valleys: ClassVar[int] = 4  # what turns a phase far is no straight line
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"

    rate: float = 0.0

    def priors(self) -> dict[str, tuple[float, float]]:
        """Clocks are good to some parts in a million, cheap ones to some hundred."""
        return {"rate": (0.0, CRYSTAL)}

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels as a wrong clock samples them."""
        return self._change(columns, lambda x: stretched(x, rate_hz, self.rate))

    def moment(self, time: Array) -> Array:
        """Return the time that a right clock would have shown."""
        return time * (1 + self.rate)

    def undo(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels as a right clock would have sampled them."""
        return self._change(columns, lambda x: stretched(x, rate_hz, 1 / (1 + self.rate) - 1))

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return clocks that are off by a sample or ten over the longest recording."""
        once = 1 / (around.sampling_hz * max(around.duration_s, 1e-9))
        return tuple(cls(place, size * once) for size in (1.0, -1.0, 10.0, -10.0))
