"""A fault of a channel, and how seldom one is reported that is none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FALSE_ALARM = 1e-6
"""Probability that a detector reports a fault that one sound channel does not have."""

MOST_HIDDEN = 0.9
"""Share of a channel's samples that faults may hide: a filter still lives on a tenth of them, and
what would hide more is the channel's motion."""


@dataclass(frozen=True)
class Fault:
    """A fault of a channel.

    Attributes:
        name: clipping, dead_tail, dropout, spikes, offset, drift, hum or quantisation.
        size: how large it is, in the channel's unit (of clipping, dropouts and dead tails: how
            many samples).
        samples: first and last sample of each stretch that it spoils, or ().
        words: one short sentence.
        frequency: of a hum's line [Hz].
    """

    name: str
    size: float
    samples: tuple[tuple[int, int], ...] = ()
    words: str = ""
    frequency: float = np.nan

    def hides(self, count: int) -> NDArray[np.bool_]:
        """Return which of the channel's samples are spoiled, (count,)."""
        out = np.zeros(count, bool)
        for first, last in self.samples:
            out[first : last + 1] = True
        return out
