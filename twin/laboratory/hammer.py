"""The instrumented hammer."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import ExperimentError
from twin.laboratory.excitation import TimeBase, finite, positive

Array = NDArray[np.float64]


def half_sine(time: Array, start_s: float, width_s: float, peak_n: float) -> Array:
    """Return a half-sine pulse [N] of impulse 2 peak_n width_s / pi [N s], (samples,)."""
    phase = (np.asarray(time) - start_s) / width_s
    return np.where((phase > 0) & (phase < 1), peak_n * np.sin(np.pi * phase), 0.0)


@dataclass(frozen=True)
class Hammer:
    """A half-sine blow, and on request a second one where the hammer bounced back.

    Attributes:
        width_s: duration of the contact [s].
        peak_n: largest force [N]; negative hits from the other side.
        delay_s: pre-trigger, from the record's start to the first contact [s].
        bounce_after_s: from the first contact to that of the second blow [s], or None for a
            clean single blow.
        bounce_strength: peak of the second blow over that of the first.

    Raises:
        ExperimentError: a value out of its range, or a second blow within the first.

    Source: the paper's experiment, Fig. 4 (first floor, 32 Hz, 32 s).
    """

    width_s: float = 0.008
    peak_n: float = 20.0
    delay_s: float = 0.5
    bounce_after_s: float | None = None
    bounce_strength: float = 0.4

    kind = "hammer"
    moves_the_ground = False

    def __post_init__(self) -> None:
        positive(self.width_s, "the width of a blow", "seconds")
        if not (math.isfinite(self.peak_n) and self.peak_n != 0):
            raise ExperimentError(f"the peak of a blow must not be zero [N], not {self.peak_n:g}")
        finite(self.delay_s, "the delay of a blow", "s")
        if self.bounce_after_s is not None:
            finite(self.bounce_after_s, "the time between two blows", "s")
            positive(self.bounce_strength, "the strength of the second blow", "times the first")
            if self.bounce_after_s < self.width_s:
                raise ExperimentError(
                    f"the second blow, {self.bounce_after_s:g} s after the first, begins before "
                    f"the first ends at {self.width_s:g} s"
                )

    @property
    def shortest_s(self) -> float:
        """The contact's duration [s]."""
        return self.width_s

    @property
    def impulse(self) -> float:
        """Impulse of the first blow [N s]."""
        return 2 * self.peak_n * self.width_s / math.pi

    def history(self, base: TimeBase, rng: np.random.Generator) -> Array:
        """Return the force [N], (base.samples,). A hammer uses no random numbers."""
        last = self.delay_s + (self.bounce_after_s or 0.0) + self.width_s
        if last > base.duration_s:
            raise ExperimentError(
                f"the blow ends {last:g} s into the record, which is {base.duration_s:g} s long"
            )
        force = half_sine(base.time, self.delay_s, self.width_s, self.peak_n)
        if self.bounce_after_s is not None:
            second = self.delay_s + self.bounce_after_s
            force += half_sine(base.time, second, self.width_s, self.bounce_strength * self.peak_n)
        return force
