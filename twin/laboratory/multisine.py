"""Random-phase multisines with a whole number of periods in the record."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import ExperimentError
from twin.laboratory.excitation import TimeBase, checked_band, positive

Array = NDArray[np.float64]


def multisine_period(lines: NDArray[np.int64], samples: int, rms: float, phase: Array) -> Array:
    """Return one period of a sum of cosines of equal amplitude, (samples,).

    Args:
        lines: which harmonics of the period there are, each below samples / 2.
        samples: number of samples to a period.
        rms: root of the mean square over a period.
        phase: phase of each line [rad], (lines,).
    """
    spectrum = np.zeros(samples // 2 + 1, complex)
    spectrum[lines] = np.exp(1j * np.asarray(phase)) * (samples * rms / math.sqrt(2 * len(lines)))
    return np.asarray(np.fft.irfft(spectrum, samples))


@dataclass(frozen=True)
class Multisine:
    """A shaker driven by a periodic signal: sines of equal amplitude and random phases.

    Attributes:
        rms_n: RMS of the force [N].
        band_hz: lowest and highest frequency [Hz]; all lines within are excited.
        periods: whole number of periods in the record; the record's samples must be a multiple.
        lines: harmonics of the period to excite instead of all those in the band, or None.

    Raises:
        ExperimentError: a value out of its range.

    Source: Pintelon and Schoukens, System Identification: A Frequency Domain Approach, 2012.
    """

    rms_n: float = 0.1
    band_hz: tuple[float, float] = (0.5, 12.0)
    periods: int = 4
    lines: tuple[int, ...] | None = None

    kind = "multisine"
    moves_the_ground = False
    shortest_s = None

    def __post_init__(self) -> None:
        positive(self.rms_n, "the RMS level of a shaker", "newtons")
        checked_band(self.band_hz)
        if self.periods < 1:
            raise ExperimentError(f"a multisine needs at least one period, not {self.periods}")
        if self.lines is not None and (not self.lines or min(self.lines) < 1):
            raise ExperimentError("the lines of a multisine are whole numbers from 1")

    def period_samples(self, record_samples: int) -> int:
        """Return the samples to a period. Raises ExperimentError when it is no whole number."""
        samples, rest = divmod(record_samples, self.periods)
        if rest or samples < 3:
            raise ExperimentError(
                f"{self.periods} periods do not fit a record of {record_samples} samples: "
                f"its length must be a multiple of the periods, three samples each or more"
            )
        return samples

    def excited_lines(self, record_samples: int, sampling_hz: float) -> NDArray[np.int64]:
        """Return the harmonics of the period that are excited, (lines,).

        Raises:
            ExperimentError: no line lies in the band, or one lies at the Nyquist frequency or
                beyond it.
        """
        samples = self.period_samples(record_samples)
        line_hz = sampling_hz / samples
        if self.lines is not None:
            lines = np.array(sorted(set(self.lines)))
        else:
            # a tolerance, so that a band's own edge is in it whatever the rounding
            low, high = (f / line_hz for f in self.band_hz)
            lines = np.arange(max(1, math.ceil(low - 1e-9)), math.floor(high + 1e-9) + 1)
        if not len(lines):
            raise ExperimentError(
                f"no line of a multisine with lines every {line_hz:g} Hz lies between "
                f"{self.band_hz[0]:g} and {self.band_hz[1]:g} Hz"
            )
        if 2 * lines[-1] >= samples:
            raise ExperimentError(
                f"the multisine's line at {lines[-1] * line_hz:g} Hz is not below the Nyquist "
                f"frequency {sampling_hz / 2:g} Hz"
            )
        return lines

    def history(self, base: TimeBase, rng: np.random.Generator) -> Array:
        """Return the force [N], (base.samples,): zero before the settling time, then periodic."""
        lines = self.excited_lines(base.record_samples, base.sampling_hz)
        phase = rng.uniform(0, 2 * np.pi, len(lines))
        samples = self.period_samples(base.record_samples) * base.factor
        period = multisine_period(lines, samples, self.rms_n, phase)
        force = np.zeros(base.samples)
        active = base.running()
        force[active] = period[base.index[active] % samples]
        return force
