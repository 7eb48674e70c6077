"""What speaks against believing an identification: its data and its error, said first."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from twin.identification.spectra import hit_window
from twin.recording import Recording
from twin.signals.channel_faults import channel_faults
from twin.signals.pair_faults import identical

Array = NDArray[np.float64]

SPOILS = ("clipping", "dead_tail", "dropout")
"""Faults of a channel that no linear model can hold."""

LINES_A_MODE = 4
"""Real unknowns that a mode has at least: pole and one residue."""

UNEXPLAINED = 0.1
"""Share of the outputs' RMS: the residual then holds a hundredth of the power, and the intervals,
which take it for noise, are those of an instrument twenty decibels below the signal."""


def doubts_of_data(
    recordings: Sequence[Recording], inputs: Sequence[str], outputs: Sequence[str]
) -> list[str]:
    """Return one line for everything in the recordings that makes modes doubtful."""
    found = []
    for recording in recordings:
        names = [n for n in (*inputs, *outputs) if n in recording.names]
        for name in names:
            x = recording.column(name)
            kind = recording.channel(name).kind
            for fault in channel_faults(x, recording.sampling_hz, kind):
                if fault.name in SPOILS:
                    words = fault.words or fault.name
                    found.append(f"warning: {recording.source}: {name}: {words}")
        for one, other in combinations(names, 2):
            pair = identical(recording.column(one), recording.column(other))
            if pair:
                found.append(f"warning: {recording.source}: {other} and {one}: {pair.words}")
        for name in inputs:
            if name in recording.names:
                found += poor_excitation(recording.column(name), recording, name)
    return list(dict.fromkeys(found))


def poor_excitation(u: Array, recording: Recording, name: str) -> list[str]:
    """Return a warning where an input holds few frequencies only, such as a single sine.

    The number of lines that carry the power (its square over the sum of squares) is what a
    spectrum determines; four real numbers belong to every mode.
    """
    if hit_window(u[:, None]) is not None:
        return []
    window = np.hanning(len(u))
    power = np.abs(np.fft.rfft((u - np.mean(u)) * window)) ** 2
    total = float(np.sum(power))
    if total <= 0:
        return []
    lines = total**2 / float(np.sum(power**2))
    # A line under this window shows as three; two of them are no more than one frequency.
    if lines > 2 * LINES_A_MODE:
        return []
    at = float(np.argmax(power)) / recording.duration_s
    return [
        f"warning: {recording.source}: {name} holds about {max(round(lines / 2), 1)} frequency "
        f"(near {at:.4g} Hz): modes and damping cannot be told from it; excite a band"
    ]


def doubts_of_fit(nrmse: float, band_hz: tuple[float, float]) -> list[str]:
    """Return a warning where the model leaves more than noise unexplained."""
    if nrmse <= UNEXPLAINED:
        return []
    return [
        f"warning: the re-simulated outputs miss {100 * nrmse:.0f} % of RMS between "
        f"{band_hz[0]:.4g} and {band_hz[1]:.4g} Hz: before you trust what follows, try a narrower "
        "--band, look at the stabilisation diagram, and check channels, units and whether the "
        "structure is linear"
    ]
