"""The band in which an input drives the structure: above it stands only its measurement's noise.

A likelihood that takes noise of the measured force for white believes that it may hide force at
every frequency, and where there is none it prefers whatever responds less: a resonance above the
band of the excitation is estimated with far too much damping (errors in variables; Söderström 2007,
Automatica 43, section 4). So what stands above the band is left out of the input, and the noise
that is left has the band's width.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.diagnosis.measured import Measured
from twin.mechanisms.shifting import through
from twin.signals.noise_floor import noise_floor

Array = NDArray[np.float64]

SEGMENTS = 16
"""Lengths of a segment in a record: 31 of them, half overlapping, leave a spectrum a fifth of
itself uncertain."""

ABOVE_NOISE = 2.0
"""Density over the noise's from which there is power: five deviations of the spectrum."""

WIDEST = 0.5
"""Share of half the sampling rate above which a band counts as the whole: a filter's slope needs
as much again."""

SLOPE = 1.5
"""End of the filter's slope over its beginning, which is the edge of the band."""

REACH = 1.5
"""Periods of the slope's width within which the filter looks beyond the ends of a record: there it
is off by up to a tenth of the input, and farther in by less than a thousandth."""


def band_of(u: Array, rate: float) -> float:
    """Return the frequency above which an input has no power but its noise's [Hz]; inf if none.

    Args:
        u: one input's samples, (samples,).
        rate: of them [Hz].
    """
    length = len(u) // SEGMENTS
    if length < SEGMENTS or not np.any(u):
        return np.inf
    f, density = signal.welch(u, rate, nperseg=length)
    # of a blow neither the upper band is silent, nor are all of the samples
    level = min(float(np.median(density[f > WIDEST * rate / 2])), 2 * noise_floor(u) ** 2 / rate)
    powered = np.flatnonzero(density > ABOVE_NOISE * level)
    if level == 0.0 or not len(powered):
        return np.inf
    # no slower than that the ends of a record which the filter can only guess are an eighth of it
    edge = max(float(f[powered[-1]]), REACH / (SLOPE - 1) * rate / length)
    return edge if edge < WIDEST * rate / 2 else np.inf


def in_band(u: Array, band: float, rate: float) -> Array:
    """Return an input without what stands above its band, nothing delayed, (samples,).

    Args:
        u: (samples,).
        band: its edge [Hz]; inf leaves it as it is.
        rate: of the samples [Hz].
    """
    if not np.isfinite(band):
        return u

    def passed(frequency: Array) -> NDArray[np.complex128]:
        down = np.clip((frequency / band - 1) / (SLOPE - 1), 0.0, 1.0)
        return np.asarray(0.5 + 0.5 * np.cos(np.pi * down), complex)

    return through(u, passed, rate, 1 / ((SLOPE - 1) * band))


def within_band(measured: Measured, rate: float, commanded: Sequence[bool]) -> Measured:
    """Return a recording with each input in the band where it has power.

    What the inputs are near its ends, the filter can only guess: outputs there are left out.

    Args:
        measured: as its channels show it.
        rate: of the samples [Hz].
        commanded: which inputs are commands of motors, (r,): nobody measures them, and what a
            controller's noise makes of them drives the structure.
    """
    each_input = zip(measured.u.T, commanded, strict=True)
    bands = tuple(np.inf if own else band_of(u, rate) for u, own in each_input)
    u = np.column_stack([in_band(*each, rate) for each in zip(measured.u.T, bands, strict=True)])
    y = np.array(measured.y)
    guessed = int(np.ceil(REACH * rate / ((SLOPE - 1) * min(bands, default=np.inf))))
    y[:guessed], y[len(y) - guessed :] = np.nan, np.nan
    return replace(measured, u=u, y=y, bands=bands)
