"""Band-limited change of the sampling rate."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.signals.low_pass import low_pass

Array = NDArray[np.float64]

KEPT = 0.9
"""Share of the smaller Nyquist frequency up to which the signal is kept within 1e-5."""

LARGEST_RATIO = 10_000
"""Rates are matched by a fraction whose denominator is no larger than this."""


def resample(samples: Array, rate_hz: float, new_rate_hz: float, kept: float = KEPT) -> Array:
    """Return the band-limited signal through ``samples`` at another rate, without delay.

    The first output is at the first sample's time; the last is not later than the last sample.
    Beyond its ends the signal is continued by point reflection, so a record that does not start
    or end at rest shows no step there. Frequencies up to ``kept`` times the smaller of the two
    Nyquist frequencies are kept within 1e-5; those above that Nyquist frequency are removed.

    Args:
        samples: signal, time along the first axis, at least two samples.
        rate_hz: its sampling rate [Hz].
        new_rate_hz: wanted sampling rate [Hz].
        kept: share of the band; the filter's length grows with 1 / (1 - kept).

    Raises:
        ValueError: a rate is not positive, or the rates have no ratio of whole numbers up to
            10 000.
    """
    samples = np.asarray(samples, float)
    if len(samples) < 2 or not (rate_hz > 0 and new_rate_hz > 0):
        raise ValueError("resampling needs two samples and positive rates")
    ratio = Fraction(new_rate_hz / rate_hz).limit_denominator(LARGEST_RATIO)
    if ratio == 0 or abs(float(ratio) * rate_hz / new_rate_hz - 1) > 1e-9:
        raise ValueError(f"{rate_hz} Hz and {new_rate_hz} Hz have no ratio of whole numbers")
    up, down = ratio.numerator, ratio.denominator
    if up == down:
        return samples.copy()
    common_hz = rate_hz * up
    nyquist = min(rate_hz, new_rate_hz) / 2
    filter_ = low_pass(common_hz, kept * nyquist, nyquist)
    lead = -(-filter_.reach // up)
    edges = [(lead, lead)] + [(0, 0)] * (samples.ndim - 1)
    extended = np.pad(samples, edges, mode="reflect", reflect_type="odd")
    # zeros in front of the taps let the first kept output fall on the first sample's time
    start = lead * up + filter_.reach
    taps = np.concatenate([np.zeros(-start % down), filter_.taps * up])
    first = -(-start // down)
    count = (len(samples) - 1) * up // down + 1
    return signal.upfirdn(taps, extended, up, down, axis=0)[first : first + count]
