"""What an analyser's low-pass makes of forces that are known as means over parts of a sample."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.signal import butter, freqs, upfirdn

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

REACH = 16
"""Samples to either side that the filter reaches: by Kaiser's formula, (A - 7.95) / (14.36 width)
for A = 104 dB and a transition from 1/2.56 of the rate, where analysers end their band, to where
they alias into it, 1 - 1/2.56."""

SHAPE = 10.5
"""Of Kaiser's window, 0.1102 (A - 8.7): the filter stops 104 dB, as those of 24 bits do."""

LINES = 512
"""Frequencies, up to the sampling rate, that the weights are computed from: a kernel repeats after
twice as many samples, far beyond its reach."""

POINTS = 8
"""Of the quadrature over a sample: exact to rounding for what is limited to its band."""

MOMENTS = 4
"""Legendre polynomials that a filtered force is written in from sample to sample. At half the
sampling rate they hold all but 3e-4 of what drives a mode there; mean and slope hold 0.90 of it."""

WITHIN = 8
"""Polynomials that forces within a sample count by: of a period a sample, the quickest that the
filter passes at all, they hold all but 3e-4, and of 0.6 of one, where it passes 1 %, but 5e-6."""

TO_POWERS = np.array(
    [[1.0, 0, 0, 0], [-1.0, 2, 0, 0], [1.0, -6, 12, 0], [-1.0, 12, -60, 120]]
)  # fmt: skip
"""These polynomials of 2 t/h - 1 by the powers (t/h)^k / k!, (MOMENTS, MOMENTS)."""


@dataclass(frozen=True)
class LowPass:
    """A low-pass, its delay at low frequencies taken out.

    Attributes:
        cut_off: where half of the amplitude is left, or half the power of Butterworth's, as a share
            of half the sampling rate.
        order: of Butterworth's filter; 0 for one of linear phase.
    """

    cut_off: float
    order: int = 0

    def response(self, f: Array) -> Complex:
        """Return the response at frequencies f [cycles a sample]."""
        if self.order:
            b, a = butter(self.order, np.pi * self.cut_off, analog=True)
            delay = a[-2] / a[-1]  # of b0 / (... + a1 s + a0) at s = 0 [samples]
            _, found = freqs(b, a, 2 * np.pi * f)
            return np.asarray(found * np.exp(2j * np.pi * f * delay))
        t = np.linspace(-REACH, REACH, 32 * REACH + 1)
        kernel = _impulse(t, self.cut_off)
        return np.asarray(np.cos(2 * np.pi * np.outer(f, t)) @ (kernel / np.sum(kernel)), complex)


def _impulse(t: Array, cut_off: float) -> Array:
    """Return the impulse response of a filter of linear phase, up to a factor, at times [samples].

    Args:
        t: the times.
        cut_off: as ``LowPass`` has it.
    """
    window = np.i0(SHAPE * np.sqrt(np.maximum(1 - (t / REACH) ** 2, 0.0)))
    return np.asarray(np.where(np.abs(t) <= REACH, np.sinc(cut_off * t) * window, 0.0))


def interpolated(x: Array, steps: int) -> Array:
    """Return band-limited signals at the parts of each sample, (samples steps, r).

    Args:
        x: at the samples, (samples, r).
        steps: parts of a sample.
    """
    padded = np.pad(x, ((REACH, REACH), (0, 0)), mode="edge")
    found = upfirdn(_between(steps), padded, steps, axis=0)
    return np.asarray(found[2 * REACH * steps :][: len(x) * steps])


@cache
def _between(steps: int) -> Array:
    """Return the kernel that interpolates, from REACH samples before to REACH after, in parts."""
    kernel = _impulse(np.arange(-REACH * steps, REACH * steps + 1) / steps, 1.0)
    for part in range(steps):
        kernel[part::steps] /= np.sum(kernel[part::steps])  # what is constant stays
    return kernel


@cache
def within(parts: int) -> Array:
    """Return orthonormal polynomials over the parts of a sample, (polynomials, parts).

    Of few parts each by itself.
    """
    if parts <= WITHIN:
        return np.eye(parts)
    middles = (2 * np.arange(parts) + 1) / parts - 1
    return np.asarray(np.linalg.qr(np.polynomial.legendre.legvander(middles, WITHIN - 1))[0].T)


def moments(x: Array, parts: int) -> Array:
    """Return sums over the parts of each sample, weighed by polynomials, (samples ., ...).

    Args:
        x: over the parts of samples, (samples parts, ...).
        parts: of a sample.
    """
    each = within(parts) @ np.reshape(x, (len(x) // parts, parts, -1))
    return np.asarray(each.reshape(-1, *x.shape[1:]))


def around(begin: Array, x: Array, weights: Array, parts: int, count: int, early: int = 0) -> Array:
    """Return weighed sums around samples, (count, w, k), by the moments of what is within each.

    Args:
        begin: what there was before the first sample, for as long as the filter reaches, (k,); and
            nothing before that.
        x: over the parts of the samples, (samples parts, k).
        weights: of moments, as many samples before one as after the next, (w, taps).
        parts: of a sample.
        count: of the sums.
        early: samples before the first one at which they begin.
    """
    polynomials = within(parts)
    reach = weights.shape[1] // len(polynomials) // 2
    before = np.tile(polynomials.sum(axis=1)[:, None] * begin, (reach, 1))
    still = np.zeros((early * len(polynomials), x.shape[1]))
    whole = np.concatenate([still, before, moments(x, parts)])
    found = sliding_window_view(whole, weights.shape[1], axis=0)[:: len(polynomials)]
    return np.asarray(np.matmul(weights, found[:count].swapaxes(1, 2)))


@cache
def weights(low_pass: LowPass, parts: int) -> Array:
    """Return the weights of the forces' means over parts of the samples around a sample.

    Args:
        low_pass: the filter.
        parts: of a sample.

    Returns:
        Of the filtered force at the sample, and of its Legendre coefficients until the next one,
        (1 + MOMENTS, (2 REACH + 1) parts): from REACH samples before to REACH samples after the
        next one.
    """
    t, kernel = _kernel(low_pass, parts)
    inside, shares = np.polynomial.legendre.leggauss(POINTS)
    values = np.polynomial.legendre.legvander(inside, MOMENTS - 1)
    terms = np.zeros((MOMENTS, len(t)))
    for x, share, value in zip(inside / 2, shares / 2, values, strict=True):
        terms += (2 * np.arange(MOMENTS) + 1)[:, None] * np.outer(
            share * value, kernel(0.5 + x - t)
        )
    shown = kernel(-t)
    terms[0] /= np.sum(terms[0])
    return np.vstack([shown / np.sum(shown), terms])


@cache
def twice(low_pass: LowPass, parts: int) -> Array:
    """Return the same weights of the filtered force at the sample and half a sample later."""
    t, kernel = _kernel(low_pass, parts)
    shown = np.array([kernel(-t), kernel(0.5 - t)])
    return np.asarray(shown / np.sum(shown, axis=1, keepdims=True))


@cache
def in_moments(of: Callable[[LowPass, int], Array], low_pass: LowPass, parts: int) -> Array:
    """Return weights of parts, (w, taps), as those of the moments of what is within samples."""
    return moments(of(low_pass, parts).T, parts).T


def hat_response(low_pass: LowPass, parts: int) -> Callable[[Array], Array]:
    """Return the filter's response, at times [samples] after, to a hat of height 1.

    It rises from nothing and falls to nothing again over a part of a sample each.
    """
    f = (np.arange(LINES) + 0.5) / LINES
    response = low_pass.response(f) * np.sinc(f / parts) ** 2 * 2 / LINES / parts
    return lambda after: np.real(np.exp(2j * np.pi * np.multiply.outer(after, f)) @ response)


def _kernel(low_pass: LowPass, parts: int) -> tuple[Array, Callable[[Array], Array]]:
    """Return the middles of the parts around a sample, and the filter's response to their means."""
    f = (np.arange(LINES) + 0.5) / LINES
    # a mean over a part has lost sinc(f / parts) already
    response = low_pass.response(f) / np.sinc(f / parts) * 2 / LINES / parts
    t = (np.arange((2 * REACH + 1) * parts) + 0.5) / parts - REACH
    return t, lambda after: (np.exp(2j * np.pi * np.outer(after, f)) @ response).real
