"""Records in the frequency domain, ready for the maximum-likelihood fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

USABLE_FRACTION = 1 / 2.56
"""Share of the sampling rate that an analyser's anti-alias filter leaves clean."""

EXCITED_LEVEL = 1e-3
"""Bins whose input power lies this far below the strongest carry no information."""


FELT_AT_EDGE = 1e-3
"""Share of the strongest below which the band's lines do not feel a combination of free samples:
in a band far below the sampling rate, neighbouring samples differ by nothing that they see."""


@dataclass(frozen=True)
class Spectrum:
    """One record's discrete Fourier transform inside the analysed band.

    Scaled by 1/sqrt(samples), so that white noise of variance s^2 has power s^2 in every bin.

    Attributes:
        omega: angular frequencies [rad/s], (bins,).
        U: inputs, (bins, inputs).
        Y: outputs, (bins, outputs).
        samples: length of the record.
        dt: sampling interval [s].
        edge: samples at either end whose inter-sample input the periodic continuation gets
            wrong; their outputs are left free in the fit.
        transient: whether the states at the record's start and end differ in a way that is not
            known; frequency responses have none.
        from_rest: inputs of a record that starts at rest, (samples, inputs): its end state
            follows from them. None otherwise.
        noise: standard deviation of every line's noise relative to the others', as a measured
            coherence tells, (bins, outputs); None for white noise.
    """

    omega: Array
    U: ComplexArray
    Y: ComplexArray
    samples: int
    dt: float
    edge: int = 0
    transient: bool = True
    from_rest: Array | None = None
    noise: Array | None = None

    @property
    def z(self) -> ComplexArray:
        """Points on the unit circle, (bins,)."""
        return np.exp(1j * self.omega * self.dt)

    @property
    def weight(self) -> Array:
        """Reciprocal variance of each line's noise relative to the others', (bins,)."""
        if self.noise is None:
            return np.ones(len(self.omega))
        return np.asarray(1 / np.mean(self.noise**2, axis=1))

    @cached_property
    def edge_columns(self) -> ComplexArray:
        """Spectra of unit combinations of the free samples that the lines feel, (bins, n)."""
        free = np.r_[0 : self.edge, self.samples - self.edge : self.samples]
        pulses = np.exp(-1j * np.outer(self.omega * self.dt, free)) / np.sqrt(self.samples)
        if not self.edge:
            return pulses
        size, turn = np.linalg.eigh((pulses.conj().T @ pulses).real)
        return np.asarray(pulses @ turn[:, size > FELT_AT_EDGE**2 * size[-1]])


def spectrum(
    u: Array, y: Array, dt: float, band_hz: tuple[float, float], edge: int = 0
) -> Spectrum:
    """Transform one record (samples, channels) and keep the bins inside the band.

    Raises:
        IdentificationError: no bin lies inside the band.
    """
    samples = len(u)
    freq = np.fft.rfftfreq(samples, dt)
    # Bin 0 holds sensor offsets and the last bin of an even record is real: neither is used.
    keep = (freq >= band_hz[0]) & (freq <= band_hz[1]) & (freq > 0) & (freq < 0.5 / dt)
    if not keep.any():
        raise IdentificationError(
            f"no frequency line lies between {band_hz[0]:g} and {band_hz[1]:g} Hz; the lines are "
            f"{freq[1]:g} Hz apart and end at {freq[-1]:g} Hz"
        )
    scale = 1 / np.sqrt(samples)
    U, Y = (np.asarray(np.fft.rfft(x, axis=0)[keep] * scale, complex) for x in (u, y))
    omega = np.asarray(2 * np.pi * freq[keep], float)
    return Spectrum(omega, U, Y, samples, dt, edge)


def excited_band(inputs: Sequence[Array], dt: float) -> tuple[float, float]:
    """Return the band [Hz] that the inputs excite, at most up to the usable bandwidth.

    The power of all inputs is smoothed over neighbouring lines; the band spans what exceeds a
    thousandth of the strongest, up to the last line that does so itself: smoothing smears the
    sharp end of a multisine.
    """
    low, high = np.inf, 0.0
    top = USABLE_FRACTION / dt
    for u in inputs:
        freq = np.fft.rfftfreq(len(u), dt)
        power = np.sum(np.abs(np.fft.rfft(u, axis=0)) ** 2, axis=1)
        width = max(len(freq) // 64, 1)
        smooth = np.convolve(power[1:], np.ones(width) / width, mode="same")
        strong = np.minimum(smooth, power[1:]) > EXCITED_LEVEL * smooth.max()
        excited = freq[1:][strong & (freq[1:] <= top)]
        if len(excited):
            low, high = min(low, float(excited[0])), max(high, float(excited[-1]))
    return (low, high) if high > low else (0.0, top)


def hit_window(u: Array, level: float = 5.0) -> tuple[int, int] | None:
    """Return the samples [start, stop) of a hammer's hits, or None for any other input.

    An input is a hammer's when half of its samples or more are quiet: below ``level`` standard
    deviations of the noise that the quietest half shows.
    """
    size = np.max(np.abs(u - np.median(u, axis=0)), axis=1)
    quiet = np.quantile(size, 0.5)
    if size.max() < 50 * quiet or size.max() == 0:
        return None
    busy = np.flatnonzero(size > level * quiet / 0.6745)
    if busy[-1] - busy[0] > len(u) // 2:
        return None
    return int(busy[0]), int(busy[-1]) + 1
