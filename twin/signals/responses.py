"""Frequency responses that another program measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

PERFECT = 1e-6
"""Distance from 0 and 1 that no coherence keeps: single precision ends there."""

NEIGHBOURS = 4
"""Lines on either side whose noise is taken to be alike; a noise level from nine lines of two
averages each is known to a third of its value."""


@dataclass(frozen=True)
class ResponseSet:
    """A matrix of frequency responses at common lines.

    Attributes:
        frequency_hz: lines [Hz], rising, (lines,).
        H: response of every output to every input, (lines, outputs, inputs).
        outputs: names of the responding degrees of freedom.
        inputs: names of the driven ones.
        source: where it came from.
        notes: what was done on reading.
        coherence: ordinary coherence, (lines, outputs, inputs), or None.
    """

    frequency_hz: Array
    H: ComplexArray
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    source: str = "responses"
    notes: tuple[str, ...] = ()
    coherence: Array | None = None

    def noise(self) -> Array | None:
        """Return the standard deviation of every response, up to a factor, from its coherence.

        The random error of an averaged response is |H| sqrt((1 - C) / (C averages)); its power is
        averaged over neighbouring lines, as a coherence of few averages is itself uncertain.

        Returns:
            (lines, outputs, inputs), of median 1 for each pair; None without a coherence, or where
            it is 1 throughout because nothing was averaged.

        Source: Bendat and Piersol, Random Data, 4th edition, section 9.2.
        """
        if self.coherence is None or np.all(self.coherence > 1 - PERFECT):
            return None
        coherence = np.clip(self.coherence, PERFECT, 1 - PERFECT)
        power = np.abs(self.H) ** 2 * (1 - coherence) / coherence
        width = 2 * NEIGHBOURS + 1
        near = np.ones(width)
        count = np.convolve(np.ones(len(power)), near, mode="same")
        smooth = np.apply_along_axis(np.convolve, 0, power, near, "same") / count[:, None, None]
        size = np.sqrt(np.maximum(smooth, np.finfo(float).tiny))
        return np.asarray(size / np.median(size, axis=0))
