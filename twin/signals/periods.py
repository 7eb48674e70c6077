"""Periodic recordings: the mean period, and periods kept apart."""

from __future__ import annotations

from dataclasses import replace

from twin.errors import RecordingError
from twin.recording import Recording

SETTLING = 3
"""With this many periods to average, the first is left out: it may hold the start's transient."""


def mean_period(recording: Recording, period: int, unseen: int = 0) -> Recording:
    """Return the mean of the recording's whole periods but the last ``unseen`` ones.

    Noise falls with the square root of the number of periods; what repeats stays.

    Args:
        recording: driven by a periodic excitation, in steady state.
        period: samples in a period.
        unseen: periods at the end that are left out.

    Raises:
        RecordingError: fewer whole periods than that.
    """
    used = whole_periods(recording, period) - unseen
    if used < 1:
        raise RecordingError(
            f"{recording.source}: {recording.samples} samples hold {used + unseen} periods of "
            f"{period}; {unseen} unseen periods leave none to fit"
        )
    first = 1 if used >= SETTLING else 0
    blocks = recording.data[first * period : used * period].reshape(used - first, period, -1)
    note = f"{recording.source}: mean of periods {first + 1} to {used}"
    return replace(recording, data=blocks.mean(axis=0), notes=(*recording.notes, note))


def last_periods(recording: Recording, period: int, count: int) -> Recording:
    """Return the last ``count`` whole periods, one after the other, unaveraged."""
    whole = whole_periods(recording, period)
    return recording.trim((whole - count) * period, whole * period)


def whole_periods(recording: Recording, period: int) -> int:
    """Return how many whole periods the recording holds."""
    return recording.samples // period
