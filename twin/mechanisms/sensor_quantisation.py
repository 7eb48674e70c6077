"""A channel whose steps are coarse: a range far too large, too few bits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.signals.channel_faults import quantisation
from twin.signals.fault import FALSE_ALARM

TIED = 0.5
"""Share of equal neighbours up to which rounding adds white noise: a motion that makes so many goes
on by half a step a sample or more, and errors correlate by exp(-2 pi^2 / 4) = 0.7 % at most."""


@dataclass(frozen=True)
class SensorQuantisation(ChannelFault):
    """Recorded = step round(true / step): noise of variance step^2 / 12 and no more information.

    It is read off the samples, not fitted.

    Attributes:
        step: from one reading to the next, in the channel's unit; not fitted.

    Source: Widrow and Kollar 2008, Quantization Noise.
    """

    name: ClassVar[str] = "sensor_quantisation"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    parameters: ClassVar = {}
    reference: ClassVar[str] = "Widrow and Kollar 2008, Quantization Noise"
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"
    fitted: ClassVar[bool] = False

    step: float = 0.0

    def scaled(self, factor: float) -> Self:
        """Return the fault as it is: a step is what it is."""
        return self

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels in whole steps."""
        if not self.step:
            return self._change(columns, np.copy)
        return self._change(columns, lambda x: self.step * np.round(x / self.step))

    def spoiled(self, reading: Array) -> NDArray[np.bool_]:
        """Return the samples of readings that stay what they are for longer than chance makes them.

        The motion is less than a step there, and the error of rounding is the motion itself.
        """
        hidden = np.zeros(len(reading), bool)
        if not self.step or len(reading) < 2:
            return hidden
        starts = np.concatenate([[0], np.flatnonzero(np.abs(np.diff(reading)) > self.step / 2) + 1])
        ends = np.append(starts[1:], len(reading))
        longest = 1 + np.log(FALSE_ALARM / len(reading)) / np.log(TIED)
        for first, end in zip(starts, ends, strict=True):
            hidden[first:end] = end - first > longest
        return hidden

    def noise(self) -> float:
        """Return the standard deviation of what rounding adds."""
        return float(self.step / np.sqrt(12))

    @classmethod
    def found(cls, place: str, reading: Array, rate_hz: float) -> Self | None:
        """Return the step of a reading, None where it is not coarse."""
        fault = quantisation(reading)
        return None if fault is None else cls(place, fault.size)

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return the step that there is: none where the reading is not coarse."""
        found = cls.found(place, around.reading, around.sampling_hz)
        return () if found is None else (found,)
