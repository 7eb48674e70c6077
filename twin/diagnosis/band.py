"""Recordings at one rate, and the band in which a structure that is only shaken is diagnosed.

A strong earthquake is recorded much faster than the structure moves, and above the band of the
motion stand floors that bend, partitions that rattle and the table's own resonances, which no model
with one mass a storey has. A predictor that looks one sample ahead would hear little else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.errors import RecordingError
from twin.recording import Recording
from twin.signals.noise_floor import noise_floor
from twin.signals.resampling import resample

Array = NDArray[np.float64]

LEFT_OUT = 0.1
"""RMS that the band may leave out, as a share of the tolerance: what is not known to a share t of
it is not spoilt by a tenth of t."""

USED_BAND = 2.56
"""Sampling rate over the highest frequency that an analyser shows."""

PER_PERIOD = 5.0
"""Samples in a period of the highest frequency of the band: straight lines between samples, raised
to fourth order, are then a per cent off."""

SEGMENT_S = 20.0
"""Length of a spectrum's segments [s]: a twentieth of a hertz apart."""


@dataclass(frozen=True)
class Banded:
    """Recordings at the rate at which they are diagnosed.

    Attributes:
        recordings: at one rate.
        input_noise: source -> noise that the inputs show above the band, in it, (r,); empty where
            nothing was left out.
        notes: what was done.
    """

    recordings: tuple[Recording, ...]
    input_noise: dict[str, Array]
    notes: tuple[str, ...]


def one_rate(recordings: Sequence[Recording], rate: float, notes: list[str]) -> list[Recording]:
    """Resample to a rate what has another one, and say so."""
    out = []
    for r in recordings:
        if abs(r.sampling_hz / rate - 1) > 1e-9:
            notes.append(f"{r.source}: resampled from {r.sampling_hz:g} to {rate:g} Hz")
            r = _at(r, rate)
        out.append(r)
    return out


def banded(
    recordings: Sequence[Recording], train: int, tolerance: float, least_samples: int
) -> Banded:
    """Return recordings of a shaken structure in the band that holds its motion.

    Args:
        recordings: of one rate, driven by the ground alone; the first ``train`` are to explain.
        train: how many.
        tolerance: to which share the model's numbers are known.
        least_samples: that those to explain must keep together.
    """
    rate = recordings[0].sampling_hz
    left_out = (LEFT_OUT * min(tolerance, 1.0)) ** 2
    highest = max(_holding(r, 1 - left_out) for r in recordings[:train])
    seconds = sum(r.duration_s for r in recordings[:train])
    wanted = max(PER_PERIOD * highest, least_samples / seconds)
    every = int(rate / wanted)
    if every < 2:
        return Banded(tuple(recordings), {}, ())
    new = rate / every
    noise = {r.source: _noise(r) / np.sqrt(every) for r in recordings}
    note = (
        f"the ground alone drives the structure and its numbers are known to {tolerance:.0%}: "
        f"diagnosed at {new:.4g} Hz, in a band of {highest:.3g} Hz that holds all "
        f"but {left_out:.1g} of the power of the outputs; errors are those in that band"
    )
    return Banded(tuple(_at(r, new) for r in recordings), noise, (note,))


def _holding(recording: Recording, share: float) -> float:
    """Return the frequency below which the outputs have a share of their power together [Hz]."""
    y = recording.matrix(recording.outputs)
    length = min(len(y), round(SEGMENT_S * recording.sampling_hz))
    f, density = signal.welch(y, recording.sampling_hz, nperseg=length, axis=0)
    held = np.cumsum(density.sum(axis=1))
    return float(f[np.searchsorted(held, share * held[-1])])


def _noise(recording: Recording) -> Array:
    return np.array([noise_floor(recording.column(n)) for n in recording.inputs])


def _at(r: Recording, rate: float) -> Recording:
    try:
        data = resample(r.data, r.sampling_hz, rate)
    except ValueError as error:
        raise RecordingError(f"{r.source}: cannot be brought to {rate:g} Hz: {error}") from None
    return Recording(rate, r.channels, data, r.source, r.start_s, r.notes)
