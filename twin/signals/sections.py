"""Parts of recordings, and recordings at another rate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from twin.errors import RecordingError
from twin.recording import Recording
from twin.signals.resampling import resample

MOST_SAMPLES = 100_000_000
"""A resampled recording with more numbers than this is a slip of the hand."""


def resample_recording(recording: Recording, sampling_hz: float) -> Recording:
    """Return the recording at another rate, every channel through the same filter.

    Raises:
        RecordingError: a rate that is no positive number, has no ratio of whole numbers to the
            recording's, or leaves fewer than two samples or absurdly many.
    """
    if not (np.isfinite(sampling_hz) and sampling_hz > 0):
        raise RecordingError(f"{recording.source}: cannot resample to {sampling_hz} Hz")
    count = (recording.samples - 1) * sampling_hz / recording.sampling_hz + 1
    if not 2 <= count <= MOST_SAMPLES / len(recording.channels):
        raise RecordingError(
            f"{recording.source}: resampling its {recording.samples} samples from "
            f"{recording.sampling_hz:.9g} Hz to {sampling_hz:.9g} Hz would give {count:.3g}"
        )
    try:
        data = resample(recording.data, recording.sampling_hz, sampling_hz)
    except ValueError as error:
        raise RecordingError(f"{recording.source}: {error}") from None
    return replace(recording, sampling_hz=float(sampling_hz), data=data)


def trim_seconds(recording: Recording, start_s: float | None, stop_s: float | None) -> Recording:
    """Return the samples with start_s <= time < stop_s, on the recording's own time axis.

    Args:
        recording: what to cut.
        start_s: first time to keep [s]; None keeps the beginning.
        stop_s: first time to leave out [s]; None keeps the end.

    Raises:
        RecordingError: fewer than two samples would be left.
    """
    first, last = float(recording.time[0]), float(recording.time[-1])
    begin = -np.inf if start_s is None else start_s
    end = np.inf if stop_s is None else stop_s
    # a thousandth of a step makes 0.3 s include the sample at 0.30000000000000004 s
    slack = 1e-3 / recording.sampling_hz
    keep = (recording.time >= begin - slack) & (recording.time < end - slack)
    if np.count_nonzero(keep) < 2:
        raise RecordingError(
            f"{recording.source}: fewer than two samples between {begin:g} s and {end:g} s; "
            f"it lasts from {first:g} s to {last:g} s"
        )
    start = int(np.argmax(keep))
    return recording.trim(start, start + int(np.count_nonzero(keep)))
