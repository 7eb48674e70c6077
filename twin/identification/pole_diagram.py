"""The stabilisation diagram as one chooses from it: poles, and what was measured behind them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.errors import IdentificationError
from twin.identification.stabilisation import FREQUENCY_TOLERANCE, StablePole
from twin.signals.frf import Record, measured_response

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

CURVES = 4
"""Singular values that are shown at most; beyond them there is noise."""

SEGMENTS = 16
"""Segments that a spectrum of outputs alone is averaged over."""


@dataclass(frozen=True)
class PoleDiagram:
    """A stabilisation diagram over what was measured.

    Attributes:
        poles: of all orders.
        frequency_hz: lines of the curves [Hz], (lines,).
        curves: singular values at every line, largest first, (lines, curves).
        of: what they are singular values of, in words.
    """

    poles: tuple[StablePole, ...]
    frequency_hz: Array
    curves: Array
    of: str


Pick = Callable[[PoleDiagram], ComplexArray]
"""Returns the poles that are chosen [rad/s]."""


def of_responses(poles: Sequence[StablePole], frequency_hz: Array, H: ComplexArray) -> PoleDiagram:
    """Return a diagram over the singular values of frequency responses.

    Args:
        poles: of all orders.
        frequency_hz: lines [Hz], (lines,).
        H: (lines, outputs, inputs).

    Source: Shih, Tsuei, Allemang and Brown 1988 (complex mode indication function).
    """
    curves = np.linalg.svd(H, compute_uv=False)[:, :CURVES]
    of = "frequency responses" if H.shape[1:] != (1, 1) else "frequency response"
    return PoleDiagram(tuple(poles), frequency_hz, np.asarray(curves, float), of)


def of_records(
    poles: Sequence[StablePole], records: Sequence[Record], sampling_hz: float
) -> PoleDiagram:
    """Return a diagram over the responses that are measured by records of inputs and outputs."""
    found = measured_response(records, sampling_hz)
    shown = found.excited()
    return of_responses(poles, found.frequency_hz[shown], found.H[shown])


def of_outputs(poles: Sequence[StablePole], y: Sequence[Array], sampling_hz: float) -> PoleDiagram:
    """Return a diagram over the singular values of the spectra of outputs alone.

    Source: Brincker, Zhang and Andersen 2001 (frequency domain decomposition).
    """
    length = max(min(sum(map(len, y)) // SEGMENTS, *map(len, y)), 8)
    lines, channels = length // 2 + 1, y[0].shape[1]
    total = np.zeros((lines, channels, channels), complex)
    frequency = np.arange(lines) * sampling_hz / length
    for x in y:
        _, _, Z = signal.stft(x.T, sampling_hz, nperseg=length, boundary=None, padded=False)
        total += np.einsum("alt,blt->lab", Z, Z.conj())
    curves = np.linalg.svd(total, compute_uv=False)[:, :CURVES]
    return PoleDiagram(tuple(poles), frequency[1:], curves[1:], "spectra of the outputs")


def poles_near(frequencies: Sequence[float]) -> Pick:
    """Return the choice of the steadiest pole near each of some frequencies [Hz].

    Of the poles within 1 % those are looked at that have most in common with the order before;
    of the nearest column the pole of the highest order is taken.
    """

    def pick(diagram: PoleDiagram) -> ComplexArray:
        chosen = []
        at = np.array([p.frequency_hz for p in diagram.poles])
        for f in frequencies:
            near = np.flatnonzero(np.abs(at / f - 1) < FREQUENCY_TOLERANCE)
            if not len(near):
                others = at[np.argsort(np.abs(at - f))[:1]]
                hint = f"; the nearest is at {others[0]:.5g} Hz" if len(others) else ""
                raise IdentificationError(f"no pole lies within 1 % of {f:g} Hz{hint}")
            common = np.array([len(diagram.poles[i].steady) for i in near])
            best = near[common == common.max()]
            middle = at[best[np.argmin(np.abs(at[best] - f))]]
            width = diagram.poles[best[np.argmin(np.abs(at[best] - f))]].damping_ratio * middle
            column = [i for i in best if abs(at[i] - middle) <= max(width, 1e-4 * middle)]
            chosen.append(diagram.poles[max(column, key=lambda i: diagram.poles[i].order)].pole)
        return np.array(sorted(chosen, key=abs), complex)

    return pick
