"""What shakes the frame under control: eq. (57), or a recorded earthquake."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import ControlError
from twin.laboratory.excitation import TimeBase

Array = NDArray[np.float64]

PRINTED_FREQUENCIES = (1.9, 6.8)
"""The frequencies of (57) as they are printed [Hz]."""


@dataclass(frozen=True)
class WorstCase:
    """F_e(t) = sum of F_i sin(2 pi f_i t) + w(t), eq. (57).

    The paper does not print the level of w(t); here it is white up to ``noise_band_hz``, so that
    nothing above half the controller's rate aliases.

    Attributes:
        frequencies: of the harmonics [Hz].
        amplitudes: of the harmonics [N; m/s^2 for a ground motion], one for each frequency.
        noise_std: standard deviation of w(t) in its band.
        noise_band_hz: upper end of its band [Hz].
        moves_the_ground: the history is the ground's acceleration.

    Raises:
        ControlError: a number that cannot be.
    """

    frequencies: tuple[float, ...] = PRINTED_FREQUENCIES
    amplitudes: tuple[float, ...] = (0.1, 0.1)
    noise_std: float = 0.01
    noise_band_hz: float = 12.5
    moves_the_ground: bool = False

    kind = "worst case"
    shortest_s = None

    def __post_init__(self) -> None:
        if len(self.frequencies) != len(self.amplitudes) or not self.frequencies:
            raise ControlError("(57): each harmonic needs a frequency and an amplitude")
        numbers = (*self.frequencies, *self.amplitudes, self.noise_std, self.noise_band_hz)
        if not all(math.isfinite(number) and number >= 0 for number in numbers):
            raise ControlError(f"(57): numbers must not be negative, not {numbers}")

    def history(self, base: TimeBase, rng: np.random.Generator) -> Array:
        """Return the force [N] (or acceleration), (base.samples,)."""
        force = np.zeros(base.samples)
        for frequency, amplitude in zip(self.frequencies, self.amplitudes, strict=True):
            force += amplitude * np.sin(2 * np.pi * frequency * base.time)
        if self.noise_std:
            spectrum = np.fft.rfft(rng.standard_normal(base.samples))
            spectrum[np.fft.rfftfreq(base.samples, 1 / base.rate_hz) > self.noise_band_hz] = 0
            noise = np.fft.irfft(spectrum, base.samples)
            force += self.noise_std / noise.std() * noise
        return force
