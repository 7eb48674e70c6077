"""Responses of a linear structure from rest, by the numerical Laplace transform.

    H(s) = (Cd + s Cv + s^2 Ca) (K + s R + s^2 M)^-1 B + Cu,        s = decay + i w

Along s with a positive real part histories fade, so that a transform of finite length does not wrap
around, however little damping there is.

Source: Wilcox 1978, Numerical Laplace transformation and inversion, Int. J. Elect. Eng. Educ. 15.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.model.linear import LinearModel
from twin.model.transfer import receptance, transfer

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

PADDED = 2
"""Length of a transform over that of the recording."""

FADED = 1e-8
"""What wraps around after a transform's length, as a share: far above rounding, which grows by the
root of its inverse, and far below any noise."""


@dataclass(frozen=True)
class Transform:
    """The transform of histories of one length.

    Attributes:
        samples: of a history.
        rate_hz: samples per second.
    """

    samples: int
    rate_hz: float

    @property
    def decay(self) -> float:
        """The real part of s [1/s]."""
        return float(-np.log(FADED) * self.rate_hz / (PADDED * self.samples))

    @property
    def s(self) -> Complex:
        """Where it is taken [1/s], (frequencies,)."""
        hertz = np.fft.rfftfreq(PADDED * self.samples, 1 / self.rate_hz)
        return np.asarray(self.decay + 2j * np.pi * hertz)

    @property
    def _fade(self) -> Array:
        return np.exp(-self.decay * np.arange(self.samples) / self.rate_hz)

    def forward(self, histories: Array) -> Complex:
        """Return the transform of histories, (samples, k) to (frequencies, k)."""
        faded = histories * self._fade[:, None]
        return np.asarray(np.fft.rfft(faded, PADDED * self.samples, axis=0))

    def back(self, spectra: Complex) -> Array:
        """Return histories from their transform, (frequencies, ...) to (samples, ...)."""
        faded = np.fft.irfft(spectra, PADDED * self.samples, axis=0)[: self.samples]
        return np.asarray(faded / self._fade.reshape(-1, *[1] * (faded.ndim - 1)), float)


def driven_by(model: LinearModel, place: str) -> LinearModel:
    """Return the model with one input: a force [N] along a port, or a base's acceleration."""
    if place in model.places("base"):
        base = model.base[model.base_axis(place)]
        row, direct = -base.row, base.acc
    else:
        row, direct = model.port(place), np.zeros(len(model.outputs))
    return replace(model, inputs=("effect",), B=row[:, None], Cu=direct[:, None])


def response(model: LinearModel, inputs: Array, rate_hz: float) -> Array:
    """Return the outputs for inputs from rest, (samples, m).

    Args:
        model: the structure.
        inputs: in the order of the model's, (samples, r).
        rate_hz: samples per second.
    """
    over = Transform(len(inputs), rate_hz)
    return over.back(np.einsum("fmr,fr->fm", transfer(model, over.s), over.forward(inputs)))


def force_response(model: LinearModel, place: str, force: Array, rate_hz: float) -> Array:
    """Return the outputs for a force at one place, (samples, m).

    Args:
        model: the structure.
        place: a port, or a base whose acceleration [m/s^2] stands for the force.
        force: its history [N], (samples,).
        rate_hz: samples per second.
    """
    return response(driven_by(model, place), force[:, None], rate_hz)


def motion(model: LinearModel, inputs: Array, rate_hz: float) -> tuple[Array, Array]:
    """Return the coordinates and their rates for inputs from rest, (samples, n) each."""
    over = Transform(len(inputs), rate_hz)
    q = np.einsum("fij,fj->fi", receptance(model, over.s) @ model.B, over.forward(inputs))
    return over.back(q), over.back(over.s[:, None] * q)
