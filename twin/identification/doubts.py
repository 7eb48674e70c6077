"""What speaks against believing an identification: its data and its error, said first."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from twin.identification.spectra import excited_band, hit_window
from twin.recording import Recording
from twin.signals.channel_faults import clipping, dead_tail, dropouts
from twin.signals.pair_faults import clock, clock_far_off, identical, reversed_polarity

Array = NDArray[np.float64]

ALIKE = 0.9999
"""Correlation below which two channels are not worth comparing reading by reading."""

LINES_A_MODE = 4
"""Real unknowns that a mode has at least: pole and one residue."""

UNEXPLAINED = 0.1
"""Share of the outputs' RMS: the residual then holds a hundredth of the power, and the intervals,
which take it for noise, are those of an instrument twenty decibels below the signal."""


WARNING = "warning: "
"""How a note begins that has to be read before the modes."""


def warnings_and_notes(notes: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the notes that are warnings, and the others."""
    first = [note for note in notes if note.startswith(WARNING)]
    return first, [note for note in notes if not note.startswith(WARNING)]


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
            if not np.ptp(x) and np.any(x):
                found.append(f"warning: {recording.source}: {name} is constant at {x[0]:.4g}")
            # Of a channel's faults those that no linear model can hold.
            spoils = clipping(x), dead_tail(x), dropouts(x, kind in ("force", "torque"))
            for fault in (f for f in spoils if f is not None):
                words = fault.words or fault.name
                found.append(f"warning: {recording.source}: {name}: {words}")
        found += [f"warning: {recording.source}: {line}" for line in _pairs(recording, names)]
        for name in inputs:
            if name in recording.names:
                found += poor_excitation(recording.column(name), recording, name)
    return list(dict.fromkeys(found))


def _pairs(recording: Recording, names: Sequence[str]) -> list[str]:
    """Return what two channels together show: one signal, two clocks, a sign that is reversed."""
    found = []
    columns = {n: recording.column(n) for n in names if np.ptp(recording.column(n))}
    alike = np.abs(np.atleast_2d(np.corrcoef(list(columns.values())))) > ALIKE
    for (i, one), (j, other) in combinations(enumerate(columns), 2):
        pair = identical(columns[one], columns[other]) if alike[i, j] else None
        if pair:
            found.append(f"{other} and {one}: {other} {pair.words}")
    rate = recording.sampling_hz
    moving = [n for n in columns if recording.channel(n).kind == "acc"]
    forces = [n for n in columns if recording.channel(n).kind == "force"]
    hammer = bool(forces) and hit_window(recording.matrix(forces)) is not None
    for other in moving:
        # A hit's decay says nothing of clocks late in the record; a lone force drives throughout.
        against = moving[:1] + (forces if len(forces) == 1 and not hammer else [])
        for one in (n for n in against if n != other):
            pair = clock_far_off(columns[one], columns[other], rate)
            pair = pair or clock(columns[one], columns[other], rate)
            if pair:
                found.append(f"{other}: against {one} {pair.words}")
                break
        for one in (n for n in forces if n.partition("_")[2] == other.partition("_")[2]):
            pair = reversed_polarity(columns[one], columns[other], rate)
            if pair:
                found.append(f"{other}: against {one} {pair.words}")
    return found


def doubts_of_band(
    inputs: Sequence[Array], dt: float, band_hz: tuple[float, float] | None, source: str
) -> list[str]:
    """Return a warning where the inputs excite little of a band that was asked for."""
    if band_hz is None:
        return []
    low, high = excited_band(inputs, dt)
    inside = max(min(high, band_hz[1]) - max(low, band_hz[0]), 0)
    if inside > (band_hz[1] - band_hz[0]) / 2:
        return []
    return [
        f"warning: {source}: the input excites {low:.4g} to {high:.4g} Hz, less than half of the "
        f"band from {band_hz[0]:.4g} to {band_hz[1]:.4g} Hz: choose another with --band"
    ]


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
