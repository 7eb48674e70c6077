"""Linear-phase low-pass filters and the decimation of a spectrum analyser."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.arrays import frozen

Array = NDArray[np.float64]

ANALYSER_BANDWIDTH = 2.56
"""A spectrum analyser that samples at fs is flat up to fs / 2.56."""

ATTENUATION_DB = 104.0
"""Stopband attenuation; with Kaiser's window the passband ripple is the same number."""


@dataclass(frozen=True)
class LowPass:
    """A symmetric FIR filter: the same delay at every frequency, taken out by ``decimate``.

    Attributes:
        taps: impulse response, odd in number, symmetric, sum 1, (taps,).
        rate_hz: sampling rate it is meant for [Hz].
        pass_hz: flat within 1e-5 up to here [Hz].
        stop_hz: below 1e-5 (-100 dB) from here on [Hz].
    """

    taps: Array
    rate_hz: float
    pass_hz: float
    stop_hz: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "taps", frozen(self.taps, float))
        if len(self.taps) % 2 != 1:
            raise ValueError("a filter without delay has an odd number of taps")

    @property
    def reach(self) -> int:
        """How many samples before and after its own instant an output depends on."""
        return (len(self.taps) - 1) // 2

    def gain(self, frequency_hz: Array) -> Array:
        """Return the real, delay-free frequency response at the given frequencies [Hz]."""
        _, response = signal.freqz(self.taps, worN=np.asarray(frequency_hz), fs=self.rate_hz)
        delay = np.exp(2j * np.pi * np.asarray(frequency_hz) / self.rate_hz * self.reach)
        return np.real(response * delay)


def low_pass(rate_hz: float, pass_hz: float, stop_hz: float, reach_multiple: int = 1) -> LowPass:
    """Design a low-pass filter with Kaiser's window, -6 dB midway between the two edges.

    Args:
        rate_hz: sampling rate [Hz].
        pass_hz: end of the passband [Hz].
        stop_hz: start of the stopband [Hz], at most half the sampling rate.
        reach_multiple: the reach is rounded up to a multiple of this.

    Raises:
        ValueError: the edges are not 0 < pass_hz < stop_hz <= rate_hz / 2.

    Source: Kaiser, 1974, through ``scipy.signal.kaiserord``.
    """
    if not 0 < pass_hz < stop_hz <= rate_hz / 2:
        raise ValueError(f"no low-pass from {pass_hz} to {stop_hz} Hz at {rate_hz} Hz")
    count, beta = signal.kaiserord(ATTENUATION_DB, (stop_hz - pass_hz) / (rate_hz / 2))
    reach = -(-(count // 2) // reach_multiple) * reach_multiple
    middle = (pass_hz + stop_hz) / 2
    taps = signal.firwin(2 * reach + 1, middle, window=("kaiser", beta), fs=rate_hz)
    return LowPass(taps, rate_hz, pass_hz, stop_hz)


def anti_alias(sampling_hz: float, factor: int, cut_off_hz: float | None = None) -> LowPass:
    """Return the filter in front of a sampler that keeps one sample in ``factor``.

    By default the cut-off (-6 dB) is half the sampling rate; the passband then ends at
    sampling_hz / 2.56 and what lies beyond sampling_hz - sampling_hz / 2.56 is stopped, so that
    nothing can alias into the passband. Another cut-off scales both edges.

    Args:
        sampling_hz: rate after decimation [Hz].
        factor: rate before decimation over rate after it, at least 2.
        cut_off_hz: frequency at which half of the amplitude is left [Hz].
    """
    cut_off = sampling_hz / 2 if cut_off_hz is None else cut_off_hz
    pass_hz = cut_off * 2 / ANALYSER_BANDWIDTH
    return low_pass(sampling_hz * factor, pass_hz, 2 * cut_off - pass_hz, reach_multiple=factor)


def decimate(history: Array, factor: int, filter_: LowPass) -> Array:
    """Filter and keep one sample in ``factor``, using true data at both ends.

    Output k belongs to input sample ``filter_.reach + k * factor``: the history has to begin
    and end ``filter_.reach`` samples outside the wanted record, and nothing is made up there.

    Args:
        history: samples at the high rate, time along the first axis.
        factor: how many input samples there are to one output sample; the filter's reach is a
            multiple of it.
        filter_: the anti-aliasing filter.

    Returns:
        The samples whose whole neighbourhood is in the history.

    Raises:
        ValueError: the history is shorter than the filter, or the reach does not fit the factor.
    """
    length = len(filter_.taps)
    if len(history) < length:
        raise ValueError(f"{len(history)} samples are fewer than the filter's {length} taps")
    if filter_.reach % factor:
        raise ValueError(f"the filter's reach {filter_.reach} is no multiple of {factor}")
    count = (len(history) - length) // factor + 1
    first = 2 * filter_.reach // factor
    # upfirdn computes only the outputs that are kept
    return signal.upfirdn(filter_.taps, history, up=1, down=factor, axis=0)[first : first + count]
