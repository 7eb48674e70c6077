"""Checks that a recording is fit for analysis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.channel import GROUND
from twin.errors import RecordingError, available
from twin.recording import Recording

Array = NDArray[np.float64]

SHORTEST_RUN = 3
"""Equal samples in a row at the limit that make a clipped peak."""

STEEP = 3.0
"""A clipped peak is entered and left by more than this many steps of the converter.

A smooth peak that stays L samples within one step lies within (1 + 2/L)^2 steps one sample
further out: 2.8 for L = 3, less for longer ones.
"""

FEWEST_LEVELS = 16
"""A signal with fewer distinct values cannot be told from a clipped one."""


def require_excitation(recording: Recording) -> None:
    """Raise RecordingError unless some input varies: a force, or the ground's acceleration."""
    names = [c.name for c in recording.channels if c.is_input]
    if not any(c.kind == "force" for c in recording.channels):
        names += [c.name for c in recording.channels if c.element == GROUND]
    if not names:
        raise RecordingError(
            f"{recording.source}: no input: it needs a force (such as 'force_floor1 [N]') or "
            f"{GROUND}; it has {available(recording.names)}"
        )
    if any(np.ptp(recording.column(name)) > 0 for name in names):
        return
    values = ", ".join(f"'{name}' is {recording.column(name)[0]:g} throughout" for name in names)
    raise RecordingError(f"{recording.source}: nothing excites the structure: {values}")


def require_samples(recording: Recording, fewest: int, purpose: str) -> None:
    """Raise RecordingError if there are fewer samples than a purpose ("order 4") needs."""
    if recording.samples < fewest:
        raise RecordingError(
            f"{recording.source}: {recording.samples} samples are too few for {purpose}, "
            f"which needs at least {fewest}"
        )


def clipping_warnings(recording: Recording) -> tuple[str, ...]:
    """Return one line for each channel that looks clipped."""
    return tuple(
        f"warning: channel '{name}' looks clipped: {count} samples at the end of its range"
        for name, count in clipped_channels(recording).items()
    )


def clipped_channels(recording: Recording) -> dict[str, int]:
    """Return the channels that look clipped and how many samples lie at their limit.

    A converter at the end of its range repeats one value, which the signal reaches and leaves
    steeply; a quiet signal of few steps repeats its values too, but is never steep there.
    """
    counts = {name: clipped_samples(recording.column(name)) for name in recording.names}
    return {name: count for name, count in counts.items() if count}


def clipped_samples(x: Array) -> int:
    """Return how many samples stand at the largest or the smallest value because they must.

    Readings too fine to repeat never take their largest value three times by chance; of others
    the samples in plateaus count.
    """
    if (count := _repeated_limits(x)) > 0:
        return count
    limits = [limit for limit in (x.min(), x.max()) if _long_runs_at(x, limit)]
    if not limits:
        return 0
    levels = np.unique(x)
    if len(levels) < FEWEST_LEVELS:
        return 0
    gaps = np.diff(levels)
    step = gaps[gaps > 1e-9 * np.ptp(x)].min()  # closer values differ by rounding only
    start, length = _runs(x)
    inside = (length >= SHORTEST_RUN) & (start > 0) & (start + length < len(x))
    start, length = start[inside], length[inside]
    value = x[start]
    entered = np.abs(value - x[start - 1])
    left = np.abs(value - x[start + length])
    plateau = (entered > STEEP * step) & (left > STEEP * step)
    # a signal's value at rest is no limit, even where it is its smallest
    plateau &= (value != np.median(x)) & (value != 0)
    at_limit = plateau & np.isin(value, limits)
    # plateaus everywhere are a held signal, such as a stepped sweep
    if np.count_nonzero(plateau) >= 2 * np.count_nonzero(at_limit):
        return 0
    return int(length[at_limit].sum())


def _repeated_limits(x: Array) -> int:
    """Return how many samples repeat a limit, where no other reading repeats."""
    limits = [v for v in (x.min(), x.max()) if v not in (0.0, np.median(x))]
    counts = [int(np.count_nonzero(x == v)) for v in limits]
    total = sum(c for c in counts if c >= SHORTEST_RUN)
    if not total:
        return 0
    others = x[~np.isin(x, limits) & (x != 0.0)]
    return total if len(others) > len(x) // 2 and len(np.unique(others)) == len(others) else 0


def _long_runs_at(x: Array, limit: float) -> bool:
    """Return whether a value is taken by enough samples in a row (quick to answer no)."""
    at = np.flatnonzero(x == limit)
    reach = SHORTEST_RUN - 1
    return len(at) > reach and bool(np.any(at[reach:] - at[:-reach] == reach))


def _runs(x: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return start and length of each run of equal samples."""
    start = np.concatenate([[0], np.flatnonzero(np.diff(x)) + 1])
    return start, np.diff(np.append(start, len(x)))
