"""Frequency response functions measured from records, with coherence and variance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft, signal

from twin.errors import RecordingError
from twin.signals.estimators import Estimator, quotient, repetition

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Record = tuple[Array, Array]
"""One record: input (samples, inputs) and output (samples, outputs)."""

SPARSE_ENERGY = 0.6
"""A hammer puts more than this share of the energy into a twentieth of the samples; a Gaussian
input puts 0.28 there, a sine 0.10."""

REPEATS = 0.98
"""Correlation of an input with itself one period later, from which on it counts as periodic."""

FORCE_WINDOW_LEVEL = 0.05
FORCE_WINDOW_MARGIN = 16

WELCH_BLOCKS = 4
EXCITED = 1e-4


@dataclass(frozen=True)
class FrequencyResponse:
    """A measured frequency response.

    Attributes:
        frequency_hz: spectral lines [Hz], (lines,).
        H: response, output unit over input unit, (lines, outputs, inputs).
        coherence: multiple coherence of each output, (lines, outputs); None where there are not
            more blocks than inputs, because it is 1 by construction then.
        input_power: mean squared magnitude of the blocks' spectra of each input, (lines, inputs).
        blocks: number of blocks averaged.
        method: how, in words.
        variance: mean squared magnitude of each response's random error, alike ``H``; None where
            coherence is.

    Source: Bendat and Piersol, Random Data, chapters 6, 7 and 9.
    """

    frequency_hz: Array
    H: ComplexArray
    coherence: Array | None
    input_power: Array
    blocks: int
    method: str
    variance: Array | None = None

    def excited(self, share: float = EXCITED) -> NDArray[np.bool_]:
        """Lines where some input has at least ``share`` of its largest power, (lines,)."""
        peak = self.input_power.max(axis=0, initial=0.0)
        return np.asarray(np.any((self.input_power >= share * peak) & (peak > 0), axis=1))


def measured_response(
    records: Sequence[Record], sampling_hz: float, estimator: Estimator = "H1"
) -> FrequencyResponse:
    """Estimate a frequency response in the way that suits the input.

    A hammer's records are transformed whole, with a force window; a periodic input is cut into
    its periods, without a window and without the first, which holds the transient; anything else
    gets Welch's method with a Hann window.

    Args:
        records: inputs and outputs, each (samples, channels).
        sampling_hz: sampling frequency [Hz].
        estimator: "H1" where noise is on the outputs, "H2" where it is on the one input, "Hv"
            where it is on both.

    Raises:
        RecordingError: no record, or too few samples for a single block for each input.
    """
    if not records:
        raise RecordingError("a frequency response needs at least one record")
    forces = [u for u, _ in records]
    if all(is_transient(u) for u in forces):
        windowed = [(force_window(u), y) for u, y in records]
        block = max(len(u) for u in forces)
        method = f"whole records of {block / sampling_hz:g} s, force window"
        return averaged(windowed, sampling_hz, block, "boxcar", method=method, estimator=estimator)
    period = common_period(forces)
    if period is not None:
        method = f"periods of {period / sampling_hz:g} s, the first left out"
        return averaged(
            records, sampling_hz, period, "boxcar", skip=period, method=method, estimator=estimator
        )
    # More inputs need more blocks: with as many as inputs the fit would be perfect and wrong.
    wanted = max(WELCH_BLOCKS, 2 * forces[0].shape[1])
    block = max(sum(len(u) for u in forces) // wanted, 8)
    block = min(block, min(len(u) for u in forces))
    method = f"Hann blocks of {block / sampling_hz:.3g} s, half overlapping"
    return averaged(
        records, sampling_hz, block, "hann", overlap=0.5, method=method, estimator=estimator
    )


def averaged(
    records: Sequence[Record],
    sampling_hz: float,
    block: int,
    window: str = "hann",
    overlap: float = 0.0,
    skip: int = 0,
    method: str = "",
    estimator: Estimator = "H1",
) -> FrequencyResponse:
    """Average the spectra of the blocks of all records and divide them.

    Args:
        records: inputs and outputs, each (samples, channels).
        sampling_hz: sampling frequency [Hz].
        block: samples of a block; shorter records are filled up with zeros.
        window: name of a ``scipy.signal`` window; all but "boxcar" take out each block's mean.
        overlap: share of a block that the next one repeats, in [0, 1).
        skip: samples left out at the start of each record.
        method: how the blocks were chosen, in words.
        estimator: which quotient, as of ``twin.signals.estimators.quotient``.

    Raises:
        RecordingError: fewer blocks than inputs, an input that is zero at every line, or H2 of
            several inputs.
    """
    taper = signal.get_window(window, block)[:, None]
    step = max(1, round(block * (1 - overlap)))
    inputs, outputs = records[0][0].shape[1], records[0][1].shape[1]
    lines = block // 2 + 1
    S_uu = np.zeros((lines, inputs, inputs), complex)
    S_yu = np.zeros((lines, outputs, inputs), complex)
    S_yy = np.zeros((lines, outputs))
    count = 0
    for u, y in _blocks(records, block, step, skip):
        if window != "boxcar":
            u, y = u - u.mean(axis=0), y - y.mean(axis=0)
        U, Y = fft.rfft(taper * u, axis=0), fft.rfft(taper * y, axis=0)
        S_uu += U[:, :, None] * U[:, None].conj()
        S_yu += Y[:, :, None] * U[:, None].conj()
        S_yy += np.abs(Y) ** 2
        count += 1
    if count < inputs:
        raise RecordingError(
            f"{count} blocks of {block} samples are too few for the frequency responses "
            f"of {inputs} inputs"
        )
    if not np.any(S_uu):
        raise RecordingError("a frequency response needs an input that is not zero throughout")
    effective = count / repetition(taper[:, 0], step, count)
    H, coherence, variance = quotient(S_uu, S_yu, S_yy, effective, estimator)
    power = np.einsum("lii->li", S_uu).real / count
    frequency = np.arange(lines) * sampling_hz / block
    return FrequencyResponse(frequency, H, coherence, power, count, method, variance)


def _blocks(
    records: Sequence[Record], block: int, step: int, skip: int
) -> Iterator[tuple[Array, Array]]:
    for u, y in records:
        if len(u) < block:
            missing = ((0, block - len(u)), (0, 0))
            yield np.pad(u, missing), np.pad(y, missing)
            continue
        for start in range(skip, len(u) - block + 1, step):
            yield u[start : start + block], y[start : start + block]


def is_transient(u: Array) -> bool:
    """Whether the input is made of short hits: most of its energy lies in few samples."""
    energy = np.sort(np.sum(np.square(u), axis=1))[::-1]
    few = max(1, len(energy) // 20)
    return bool(energy.sum() > 0 and energy[:few].sum() > SPARSE_ENERGY * energy.sum())


def force_window(u: Array) -> Array:
    """Zero the force away from the hits, so that its noise between them does not count.

    Kept are the samples above ``FORCE_WINDOW_LEVEL`` of the peak and ``FORCE_WINDOW_MARGIN``
    samples on either side, which hold the anti-alias filter's ringing.
    """
    kept = np.zeros_like(u)
    for column in range(u.shape[1]):
        x = np.abs(u[:, column])
        near = np.convolve(
            x > FORCE_WINDOW_LEVEL * x.max(initial=0.0),
            np.ones(2 * FORCE_WINDOW_MARGIN + 1),
            mode="full",
        )[FORCE_WINDOW_MARGIN : FORCE_WINDOW_MARGIN + len(x)]
        kept[:, column] = np.where(near > 0, u[:, column], 0.0)
    return kept


def common_period(forces: Sequence[Array]) -> int | None:
    """Return the period in samples that all inputs share, or None.

    An input is periodic when it correlates with itself one period later by at least
    ``REPEATS`` and holds at least three periods, so that two are left without the transient.
    """
    found = {_period(u) for u in forces}
    return found.pop() if len(found) == 1 else None


def _period(u: Array) -> int | None:
    samples = len(u)
    centred = u - u.mean(axis=0)
    spectrum = fft.rfft(centred, 2 * samples, axis=0)
    product = fft.irfft(np.sum(np.abs(spectrum) ** 2, axis=1), 2 * samples)
    # What the overlap itself holds on either side, so that the ratio is a true correlation.
    energy = np.concatenate([[0.0], np.cumsum(np.sum(centred**2, axis=1))])
    lags = np.arange(8, samples // 3 + 1)
    if not len(lags) or energy[-1] == 0:
        return None
    head, tail = energy[samples - lags], energy[-1] - energy[lags]
    correlation = product[lags] / np.sqrt(np.maximum(head * tail, np.finfo(float).tiny))
    best = float(correlation.max())
    if best < REPEATS:
        return None
    # A smooth input also resembles itself at lags next to a period: take the first local peak.
    peaks = np.flatnonzero(correlation >= min(best, 1.0) - 0.2 * (1 - REPEATS))
    first = peaks[0]
    near = correlation[first : first + max(1, int(lags[first]) // 4)]
    return int(lags[first + int(np.argmax(near))])
