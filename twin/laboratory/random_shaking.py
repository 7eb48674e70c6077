"""Band-limited random shaking, throughout the record or as a burst."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.errors import ExperimentError
from twin.laboratory.excitation import TimeBase, checked_band, positive

Array = NDArray[np.float64]

TAPER = 0.1
"""Share of a burst over which its raised-cosine edges rise and fall, both together."""


def band_limited_noise(
    samples: int, rate_hz: float, band_hz: tuple[float, float], rms: float, rng: np.random.Generator
) -> Array:
    """Return Gaussian noise with a flat spectrum in a band and nothing outside, (samples,).

    The same random numbers at another rate give the same signal, so that a finer simulation
    sees the same shaker.

    Args:
        samples: number of samples.
        rate_hz: their rate [Hz].
        band_hz: lowest and highest frequency [Hz].
        rms: root of the mean square over the samples, met exactly.
        rng: random numbers.

    Raises:
        ExperimentError: the signal is too short to hold a frequency of the band, or the band
            reaches beyond half the rate.
    """
    line_hz = rate_hz / samples
    lines = np.arange(max(1, math.ceil(band_hz[0] / line_hz)), math.floor(band_hz[1] / line_hz) + 1)
    if not len(lines) or 2 * lines[-1] >= samples:
        raise ExperimentError(
            f"no random signal of {samples / rate_hz:g} s fills the band from {band_hz[0]:g} "
            f"to {band_hz[1]:g} Hz"
        )
    spectrum = np.zeros(samples // 2 + 1, complex)
    parts = rng.standard_normal((len(lines), 2))
    spectrum[lines] = parts[:, 0] + 1j * parts[:, 1]
    noise = np.fft.irfft(spectrum, samples)
    return np.asarray(noise * (rms / np.sqrt(np.mean(noise**2))))


@dataclass(frozen=True)
class RandomShaking:
    """A shaker driven by a random generator through a band-pass.

    Attributes:
        rms_n: RMS of the force while it runs [N]; of a burst before its edges are tapered.
        band_hz: lowest and highest frequency [Hz].
        burst: None runs from the settling time to the end; a share of the record (0 to 1) begins
            with the record, from zero, and ends at zero after that share, so that the structure
            rings down within the record.

    Raises:
        ExperimentError: a value out of its range.
    """

    rms_n: float = 0.1
    band_hz: tuple[float, float] = (0.5, 12.0)
    burst: float | None = None

    kind = "random"
    moves_the_ground = False
    shortest_s = None

    def __post_init__(self) -> None:
        positive(self.rms_n, "the RMS level of a shaker", "newtons")
        checked_band(self.band_hz)
        if self.burst is not None and not 0 < self.burst <= 1:
            raise ExperimentError(
                f"a burst lasts a share of the record between 0 and 1, not {self.burst:g}"
            )

    def history(self, base: TimeBase, rng: np.random.Generator) -> Array:
        """Return the force [N], (base.samples,)."""
        force = np.zeros(base.samples)
        if self.burst is None:
            active = base.running()
        else:
            length = round(self.burst * base.record_samples) * base.factor
            active = slice(-base.first, -base.first + length)
        count = active.stop - active.start
        # whole samples of the record: the same signal whatever the physics rate
        whole = -(-count // base.factor) * base.factor
        noise = band_limited_noise(whole, base.rate_hz, self.band_hz, self.rms_n, rng)[:count]
        if self.burst is not None:
            noise *= signal.windows.tukey(count, TAPER)
        force[active] = noise
        return force
