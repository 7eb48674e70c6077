"""Recordings turned into the arrays that the identification works on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError, RecordingError, available
from twin.identification.spectra import Spectrum, excited_band, hit_window, spectrum
from twin.recording import Recording

Array = NDArray[np.float64]

LEAST_SAMPLES = 32
SMALLEST, LARGEST = 1e-15, 1e15
"""Peaks beyond these, in SI units, are slips of a unit and would overflow."""

WINDOW_MARGIN = 8
"""Samples kept on either side of a hammer's hit: the anti-alias filter's ringing."""

EDGE_SAMPLES = 8
EDGE_COLUMNS = 128
STILL_AT_EDGES = 1e-3
RISE = 0.1
"""Share of its peak at which a force has begun; an anti-alias filter rings below it."""

AT_REST = 0.01
"""Share of the peak: an earlier hit's motion below it costs less than unknowns would."""


@dataclass(frozen=True)
class Records:
    """Inputs and outputs of all recordings, in the same channels and at the same rate.

    Attributes:
        u: inputs, hits windowed, one (samples, inputs) a record.
        y: outputs, one (samples, outputs) a record.
        hits: the window [start, stop) of the hits of each record, or None.
        at_rest: whether every record starts before anything moves.
        still: outputs that were left out because they never move.
    """

    recordings: tuple[Recording, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    u: tuple[Array, ...]
    y: tuple[Array, ...]
    hits: tuple[tuple[int, int] | None, ...]
    at_rest: bool
    still: tuple[str, ...] = ()

    @property
    def dt(self) -> float:
        """Sampling interval [s]."""
        return 1 / self.recordings[0].sampling_hz

    @property
    def pairs(self) -> list[tuple[Array, Array]]:
        """(input, output) of each record."""
        return list(zip(self.u, self.y, strict=True))

    @property
    def notes(self) -> tuple[str, ...]:
        """What was done to the inputs."""
        lines = [f"{name} never moves and was left out" for name in self.still]
        for recording, hit in zip(self.recordings, self.hits, strict=True):
            if hit is not None:
                start, stop = (recording.start_s + i * self.dt for i in hit)
                lines.append(
                    f"{recording.source}: the force outside its hits "
                    f"({start:.3g} to {stop:.3g} s) is noise and was set to zero"
                )
        return tuple(lines)

    def spectra(self, band_hz: tuple[float, float] | None, edges: bool) -> list[Spectrum]:
        """Transform every record; ``edges`` leaves the first and last outputs free."""
        band = band_hz or excited_band(self.u, self.dt)
        affordable = EDGE_COLUMNS // (2 * len(self.outputs) * len(self.u))
        found = []
        for u, y in self.pairs:
            ends = np.abs(np.vstack([u[:EDGE_SAMPLES], u[-EDGE_SAMPLES:]])).max(axis=0)
            still = np.all(ends <= STILL_AT_EDGES * np.abs(u).max(axis=0))
            edge = 0 if still or not edges else min(EDGE_SAMPLES, affordable)
            found.append(spectrum(u, y, self.dt, band, edge))
        return found

    def wide_spectra(self, band_hz: tuple[float, float] | None) -> list[Spectrum]:
        """Transform every record; those that start at rest need no unknown state at their ends."""
        found = []
        for s, u, y, hit in zip(
            self.spectra(band_hz, edges=False), self.u, self.y, self.hits, strict=True
        ):
            calm = hit is not None and _calm_before(y, _rise(u))
            found.append(replace(s, transient=not calm, from_rest=u if calm else None))
        return found


def _rise(u: Array) -> int:
    """Return the first sample of a hit proper: what precedes it is the filter's ringing."""
    size = np.max(np.abs(u) / np.maximum(np.abs(u).max(axis=0), SMALLEST), axis=1)
    return int(np.argmax(size > RISE))


def _calm_before(y: Array, hit: int) -> bool:
    """Whether what moves before the hit is less than a hundredth of what moves after it."""
    if hit == 0:
        return False
    before = y[:hit] - y.mean(axis=0)
    return bool(np.all(np.sqrt(np.mean(before**2, axis=0)) < AT_REST * np.abs(y).max(axis=0)))


def prepare(
    recordings: Sequence[Recording],
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
) -> Records:
    """Collect what several recordings share. A force one of them lacks is zero there.

    Raises:
        RecordingError: different rates, no common outputs, or a named channel that is missing.
        IdentificationError: no input that moves, a constant output, or too few samples.
    """
    if not recordings:
        raise IdentificationError("no recording was given")
    first = recordings[0]
    for other in recordings[1:]:
        if not np.isclose(other.sampling_hz, first.sampling_hz, rtol=1e-9):
            raise RecordingError(
                f"{other.source} is sampled at {other.sampling_hz:g} Hz and {first.source} at "
                f"{first.sampling_hz:g} Hz; convert one with --resample"
            )
    drivers = tuple(inputs or dict.fromkeys(n for r in recordings for n in r.inputs))
    if not drivers:
        raise IdentificationError(
            f"{first.source}: no input moves; an identification needs a force or acc_ground that "
            f"is not zero (channels: {available(first.names)})"
        )
    known = dict.fromkeys(name for r in recordings for name in r.names)
    for name in (*drivers, *(outputs or ())):
        if name not in known:
            raise RecordingError(f"{first.source}: no channel '{name}'; it has {available(known)}")
    shared = [n for n in first.outputs if all(n in r.outputs for r in recordings)]
    responders = tuple(outputs or (n for n in shared if n not in drivers))
    if not responders:
        raise RecordingError(f"{first.source}: no output channel; it has {available(first.names)}")
    both = sorted(set(drivers) & set(responders))
    twice = sorted({n for n in (*drivers, *responders) if (*drivers, *responders).count(n) > 1})
    if both or twice:
        raise IdentificationError(
            f"{first.source}: '{(both or twice)[0]}' is named twice; a channel drives or responds, "
            "once"
        )
    moving = _moving(recordings, responders)
    still, responders = tuple(n for n in responders if n not in moving), moving
    _check_scale(recordings, (*drivers, *responders))
    u, y, hits = [], [], []
    kinds = {c.name: c.kind for r in recordings for c in r.channels}
    for recording in recordings:
        if recording.samples < LEAST_SAMPLES:
            raise IdentificationError(
                f"{recording.source}: {recording.samples} samples are too few; "
                f"at least {LEAST_SAMPLES} are needed"
            )
        force, hit = _driving(recording, drivers, kinds)
        u.append(force)
        y.append(recording.matrix(responders))
        hits.append(hit)
    rest = all(_starts_at_rest(a, b) for a, b in zip(u, y, strict=True))
    return Records(
        tuple(recordings), drivers, responders, tuple(u), tuple(y), tuple(hits), rest, still
    )


def _moving(recordings: Sequence[Recording], responders: Sequence[str]) -> tuple[str, ...]:
    """Leave out outputs that never move, such as the acceleration of a clamped ground."""
    moving = tuple(
        n for n in responders if any(np.ptp(r.column(n)) > 0 for r in recordings if n in r.names)
    )
    if not moving:
        raise IdentificationError(
            f"{recordings[0].source}: channel '{responders[0]}' is constant and no other output "
            "moves"
        )
    return moving


def _check_scale(recordings: Sequence[Recording], names: Sequence[str]) -> None:
    for recording in recordings:
        for name in (n for n in names if n in recording.names):
            peak = float(np.abs(recording.column(name)).max())
            if peak and not SMALLEST < peak < LARGEST:
                raise IdentificationError(
                    f"{recording.source}: channel '{name}' peaks at {peak:.3g}; no instrument "
                    "measures that, check its unit"
                )


def _driving(
    recording: Recording, drivers: Sequence[str], kinds: Mapping[str, str]
) -> tuple[Array, tuple[int, int] | None]:
    columns = []
    for name in drivers:
        if name in recording.names:
            columns.append(recording.column(name))
        elif kinds.get(name) in ("force", "torque"):
            columns.append(np.zeros(recording.samples))
        else:
            raise RecordingError(
                f"{recording.source}: no channel '{name}'; it has {available(recording.names)}"
            )
    u = np.column_stack(columns)
    if not np.any(np.ptp(u, axis=0) > 0):
        raise IdentificationError(
            f"{recording.source}: the input {', '.join(drivers)} is constant; nothing excites "
            "the structure"
        )
    hit = hit_window(u) if all(kinds[name] == "force" for name in drivers) else None
    if hit is None:
        return u, None
    start, stop = max(hit[0] - WINDOW_MARGIN, 0), min(hit[1] + WINDOW_MARGIN, len(u))
    quiet = np.ones(len(u), bool)
    quiet[start:stop] = False
    u = u - (np.median(u[quiet], axis=0) if quiet.any() else 0)
    u[quiet] = 0
    return u, (start, stop)


def _starts_at_rest(u: Array, y: Array) -> bool:
    """Whether the first samples are far below the level the record reaches."""
    head = max(len(y) // 100, 2)
    calm = np.abs(y[:head] - y[:head].mean(axis=0)).max(axis=0)
    return bool(
        np.all(calm <= 0.05 * np.abs(y).max(axis=0))
        and np.all(np.abs(u[0]) <= 0.05 * np.abs(u).max(axis=0))
    )
