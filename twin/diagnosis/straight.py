"""What straight lines between samples miss of band-limited inputs.

Lines whose corners are raised (``Problem``) hold a band-limited signal, but its images beside it:
what a hammer has near half the sampling rate is seen at another frequency, too, and a mode above it
would ring at each corner.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft
from scipy.interpolate import CubicSpline
from scipy.linalg import eigh

from twin.diagnosis.scales import ROUNDING
from twin.estimation.ringing import SILENCE, Ringing, between_samples
from twin.mechanisms.instrument import Instrument
from twin.mechanisms.shifting import through
from twin.model.linear import LinearModel

Array = NDArray[np.float64]

SPREAD = 16.0
"""Samples by which the raising of corners reaches: what a sample does there is a thousandth."""

FREQUENCIES = 513
"""At which what lines miss is found, from 0 to half the sampling rate: it is smooth between them,
for resonances in the band are in both and cancel, and images and modes above it lie apart. Four
times as many change what a beam's outputs show by less than 1e-5 of them."""

CALM = 0.7
"""Damping ratio that modes above half the sampling rate are given in steps from sample to sample:
they follow what is slow and do not ring at corners that the true force has not (at any ratio their
own is not seen: an analyser cuts their ringing off)."""

TURN = 0.95
"""Share of half the sampling rate from which on modes are given a part of that damping: a fit that
moves a mode over half the rate should find no step there. An analyser lets no more of them pass."""


def prefiltered(u: Array) -> Array:
    """Return inputs, (samples, r), whose straight lines are those of a band-limited signal.

    Straight lines lose sinc^2 of it; that is put back first.
    """
    if len(u) < 2:
        return u
    columns = [through(column, _corner, 1.0, SPREAD) for column in u.T]
    return np.column_stack(columns) if columns else u


@dataclass(frozen=True)
class HoldError:
    """What outputs show of band-limited inputs that they do not of their raised lines.

    Attributes:
        response: of the outputs to the inputs, at some frequencies from 0 to half the sampling
            rate, (k, m, r).
    """

    response: NDArray[np.complex128]

    def of(self, u: Array) -> Array:
        """Return what outputs show beyond the lines of inputs, (samples, r), as (samples, m)."""
        return self.of_spectrum(spectrum(u), len(u))

    def of_spectrum(self, inputs: NDArray[np.complex128], samples: int) -> Array:
        """Return the same, (samples, m), of inputs that come as their ``spectrum``, (., r)."""
        count = len(inputs)
        if count not in self._kept:
            known, wanted = (np.linspace(0.0, 1.0, k) for k in (len(self.response), count))
            self._kept[count] = CubicSpline(known, self.response)(wanted)
        seen = np.sum(self._kept[count] * inputs[:, None, :], axis=2)
        return np.asarray(irfft(seen, _length(samples), axis=0)[:samples])

    @cached_property
    def _kept(self) -> dict[int, NDArray[np.complex128]]:
        return {}


def spectrum(u: Array) -> NDArray[np.complex128]:
    """Return the spectrum of inputs, (samples, r), with silence after them, (., r)."""
    return np.asarray(rfft(u, _length(len(u)), axis=0))


def _length(samples: int) -> int:
    return int(SILENCE * next_fast_len(samples, real=True))


def hold_error(model: LinearModel, step_s: float, frequencies: int = FREQUENCIES) -> HoldError:
    """Return what raised lines miss of the inputs of a structure.

    Lines serve a mode well below half the sampling rate, but not what a hammer has near it. Modes
    above are stepped with more damping than theirs (``well_damped``); what moves freely is left.

    Args:
        model: the structure.
        step_s: sampling interval [s].
        frequencies: at how many it is found.
    """
    squares, shapes = _modes(model)
    held = squares > ROUNDING * np.max(squares, initial=1e-300)
    squares, shapes = squares[held], shapes[:, held]
    R, B = shapes.T @ model.R @ shapes, shapes.T @ model.B
    Cd, Cv, Ca = (C @ shapes for C in (model.Cd, model.Cv, model.Ca))
    n, w = len(squares), np.linspace(0.0, np.pi / step_s, frequencies)
    out = np.zeros((len(w), len(model.outputs) * len(model.inputs)), complex)
    for sign, damping, lines in ((1, R, False), (-1, R + _calming(squares, R, step_s), True)):
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.diag(squares), -damping]])
        poles, states = np.linalg.eig(A)
        seen = np.hstack([Cd - Ca * squares, Cv - Ca @ damping]) @ states
        driven = np.linalg.solve(states, np.vstack([0 * B, B]))
        paths = (seen[:, None, :] * driven.T[None, :, :]).reshape(out.shape[1], 2 * n)
        out += sign * _state(poles, w[:, None], step_s, lines) @ paths.T
    return HoldError(out.reshape(len(w), len(model.outputs), len(model.inputs)))


def _calming(squares: Array, R: Array, step_s: float) -> Array:
    """Return the damping that modes above half the sampling rate lack, (n, n), modal.

    Args:
        squares: of circular natural frequencies, (n,).
        R: damping of mass-normalised modes, (n, n).
        step_s: sampling interval [s].
    """
    missing = np.maximum(2 * CALM * np.sqrt(np.maximum(squares, 0.0)) - np.diag(R), 0.0)
    return np.diag(_turned(squares, step_s) * missing)


def _turned(squares: Array, step_s: float) -> Array:
    """Return what part of it modes are given, (n,), of squares of circular frequencies: 0 to 1."""
    half = np.sqrt(np.maximum(squares, 0.0)) * step_s / np.pi
    return np.asarray(np.clip((half - TURN) / (1 - TURN), 0.0, 1.0))


def ringing(model: LinearModel, places: Sequence[str], step_s: float) -> Ringing:
    """Return the modes above half the sampling rate as laws at some ports drive them.

    Args:
        model: in modal coordinates.
        places: the ports.
        step_s: sampling interval [s].
    """
    at = np.flatnonzero(above(model, step_s))
    mass = np.diag(model.M)[at]
    square, rate = np.diag(model.K)[at] / mass, np.diag(model.R)[at] / mass
    rows = np.array([model.port(place) for place in places]).reshape(len(places), len(model.M))
    seen = np.array([model.Cd, model.Cv, model.Ca])[:, :, at]
    stepped = rate + np.diag(_calming(square, np.diag(rate), step_s))
    return Ringing(square, rate, stepped, -rows.T[at] / mass[:, None], seen)


def above(model: LinearModel, step_s: float) -> NDArray[np.bool_]:
    """Return which coordinates are modes above half the sampling rate, or hardly below, (n,)."""
    return np.asarray(_turned(np.diag(model.K) / np.diag(model.M), step_s) > 0)


def _state(pole: Any, w: Array, step_s: float, lines: bool) -> NDArray[np.complex128]:
    """Return the response of x' = pole x + u to a band-limited u, or its raised lines.

    Args:
        pole: one or many.
        w: circular frequencies; they and many poles are broadcast.
        step_s: sampling interval [s].
        lines: whether u is what its raised lines are.
    """
    if not lines:
        return np.asarray(1 / (1j * w - pole))
    z, corner = np.exp(1j * w * step_s), _corner(w * step_s / (2 * np.pi))
    over, constant, ramp = between_samples(pole, step_s)
    return np.asarray((constant - ramp + z * ramp) / (z - over) * corner)


def read_error(instrument: Instrument, x: Array, step_s: float) -> Array:
    """Return what an instrument reads of a band-limited signal less what it reads of its lines.

    Args:
        instrument: of one channel.
        x: what it sees at the samples, (samples,).
        step_s: sampling interval [s].
    """
    length = SILENCE * len(x)
    w = np.asarray(2 * np.pi * np.fft.rfftfreq(length, step_s), float)
    error = np.zeros(len(w), complex)
    own = instrument.A, instrument.B
    for sign, (A, B), lines in ((1, own, False), (-1, calmed(*own, step_s), True)):
        poles, modes = np.linalg.eig(A.astype(complex))
        seen, driven = instrument.C[0] @ modes, np.linalg.solve(modes, B[:, 0])
        for p, c, b in zip(poles, seen, driven, strict=True):
            error += sign * c * b * _state(p, w, step_s, lines)
    return np.asarray(np.fft.irfft(error * np.fft.rfft(x, length), length)[: len(x)])


def calmed(A: Array, B: Array, step_s: float) -> tuple[Array, Array]:
    """Return a filter s' = A s + B u that does not ring above half the sampling rate.

    In steps from sample to sample its ringing would be seen folded into the band, where an analyser
    lets nothing of it pass. What is slow it does as before.

    Args:
        A: its states, (k, k), any number.
        B: what enters, (k,) or (k, c).
        step_s: sampling interval [s].
    """
    poles, modes = np.linalg.eig(A.astype(complex))
    size = np.abs(poles)
    ratio = -poles.real / np.maximum(size, 1e-300)
    missing = _turned(size**2, step_s) * np.maximum(CALM - ratio, 0.0)
    if not np.any(missing):
        return A, B
    ratio = ratio + missing
    damped = size * (-ratio + 1j * np.sign(poles.imag) * np.sqrt(np.maximum(1 - ratio**2, 0.0)))
    calm = (modes * damped @ np.linalg.inv(modes)).real
    return calm, calm @ np.linalg.solve(A, B)


def noise_gain(model: LinearModel, step_s: float) -> Array:
    """Return by what band-limited noise stirs each mode, (n,), more than noise in steps does.

    Held over a sample, noise keeps sinc(f h) of what it has at a frequency f. Of modes above half
    the sampling rate it stirs none, but by its jumps.
    """
    squares = np.maximum(np.diag(model.K) / np.diag(model.M), 0.0)
    periods = np.sqrt(squares) * step_s / (2 * np.pi)
    return np.asarray((1 - _turned(squares, step_s)) / np.sinc(np.minimum(periods, 0.5)))


def _corner(periods: Array) -> NDArray[np.complex128]:
    """Return by what corners are raised, at so many periods a sample."""
    return np.asarray(np.sinc(periods) ** -2, complex)


def well_damped(model: LinearModel, step_s: float) -> LinearModel:
    """Return a model whose modes above half the sampling rate do not ring.

    The modes are its own: damping that is added to another's would couple with those below.

    Raises:
        LinAlgError: masses that are not positive.
    """
    squares, shapes = _modes(model)
    rows = shapes.T @ model.M
    calming = _calming(squares, shapes.T @ model.R @ shapes, step_s)
    return model.adding(R=rows.T @ calming @ rows)


def _modes(model: LinearModel) -> tuple[Array, Array]:
    """Return squares of circular natural frequencies (n,) and mass-normalised shapes (n, n)."""
    squares, shapes = eigh(0.5 * (model.K + model.K.T), 0.5 * (model.M + model.M.T))
    return squares, shapes
