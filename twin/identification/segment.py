"""The band in segments of a few modes, each with a noise level of its own."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.identification.spectra import Spectrum

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

MODES = 6
"""Modes in a segment at most; the Gauss-Newton step of a segment grows with their square."""

LEAST_LINES = 24
"""Lines in a segment at least, for its noise level."""


@dataclass(frozen=True)
class Segment:
    """A part of the band.

    Attributes:
        low: first angular frequency [rad/s].
        high: last angular frequency [rad/s].
    """

    low: float
    high: float

    def holds(self, omega: Array) -> NDArray[np.bool_]:
        """Which frequencies lie inside."""
        return np.asarray((omega >= self.low) & (omega < self.high))

    def part(self, s: Spectrum) -> Spectrum:
        """Return the lines of a record inside the segment."""
        keep = self.holds(s.omega)
        noise = None if s.noise is None else s.noise[keep]
        return replace(s, omega=s.omega[keep], U=s.U[keep], Y=s.Y[keep], noise=noise)


def segments(omega: Array, low: float, high: float, resolution: float) -> list[Segment]:
    """Cut the band in the middle of the widest gaps between modes until few are left in each."""
    found = [Segment(low, np.nextafter(high, np.inf))]
    while True:
        sizes = [int(np.sum(s.holds(omega))) for s in found]
        cut = None
        for index in np.argsort(sizes)[::-1]:
            inside = np.sort(omega[found[index].holds(omega)])
            if len(inside) <= MODES:
                break
            middle = (inside[1:] + inside[:-1]) / 2
            least = LEAST_LINES * resolution
            allowed = (middle - found[index].low > least) & (found[index].high - middle > least)
            gaps = np.where(allowed, np.diff(inside), 0)
            if gaps.max() > 0:
                cut = index, float(middle[np.argmax(gaps)])
                break
        if cut is None:
            return found
        index, at = cut
        old = found[index]
        found[index : index + 1] = [Segment(old.low, at), Segment(at, old.high)]


def level_weights(error: ComplexArray, power: Array, noise: Array) -> Array:
    """Return 1 / standard deviation of noise of known form for every line and output.

    Args:
        error: residual, (lines, outputs).
        power: smallest variance to believe, (outputs,).
        noise: its form, relative standard deviations, (lines, outputs).
    """
    variance = np.maximum(np.mean(np.abs(error / noise) ** 2, axis=0), power)
    return np.asarray(1 / (np.sqrt(variance) * noise))
