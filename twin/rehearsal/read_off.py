"""The smallest faults of instruments: what detectors see, what a calibration is good for."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, sqrt

import numpy as np

from twin.mechanisms.mechanism import ChannelFault
from twin.recording import Recording
from twin.rehearsal.effects import Effect, adds

SMALLEST, LARGEST = 1e-3, 1e2
"""Multiples of the reference between which a limit is looked for."""

CALIBRATED = 0.005
"""Share of its reading to which an instrument is calibrated at best (ISO 16063-21): what distorts
it by less is no fault."""

CLOSE = 1.05
"""A limit is known to a twentieth: the noise moves it by more."""


def read_off_limit(effect: Effect, recordings: Sequence[Recording]) -> float:
    """Return from which multiple of its reference on a fault is seen in every recording.

    Sizes are searched by bisection of their logarithm, from a ladder's first rung that is seen.

    Args:
        effect: a fault that no fit explains.
        recordings: the plan's, nothing concealed; those without the channel do not count.
    """
    own = [r for r in recordings if set(_channels(effect)) <= set(r.names)]
    if not own:
        return inf
    size = SMALLEST
    while not _seen(effect, size, own):
        size *= 2
        if size > LARGEST:
            return inf
    if size == SMALLEST:
        return size
    low, high = size / 2, size
    while high / low > CLOSE:
        middle = sqrt(low * high)
        low, high = (low, middle) if _seen(effect, middle, own) else (middle, high)
    return high


def calibration_limit(effect: Effect, recordings: Sequence[Recording]) -> float:
    """Return from which multiple of its reference on a fault is more than a calibration's doubt.

    What is added to a channel, as hum, has no such limit: it is measured against the noise.

    Args:
        effect: a fault that a fit explains.
        recordings: the plan's, nothing concealed.
    """
    fault = effect.reference
    assert isinstance(fault, ChannelFault)
    if fault.of_motor or not fault.parameters or adds(fault):
        return 0.0
    own = [r for r in recordings if set(_channels(effect)) <= set(r.names)]
    low, high = SMALLEST**2, LARGEST
    if _distorts(effect, high, own) < CALIBRATED:
        return inf
    while high / low > CLOSE:
        middle = sqrt(low * high)
        low, high = (
            (low, middle) if _distorts(effect, middle, own) >= CALIBRATED else (middle, high)
        )
    return high


def _distorts(effect: Effect, times: float, recordings: Sequence[Recording]) -> float:
    """Return the largest change of a channel in a recording, as a share of its RMS."""
    fault, worst = effect.at(times), 0.0
    assert isinstance(fault, ChannelFault)
    for recording in recordings:
        columns = {name: recording.column(name) for name in fault.channels}
        faulty = fault.distort(columns, recording.sampling_hz)
        for name, values in columns.items():
            if level := float(np.sqrt(np.mean(values**2))):
                change = float(np.sqrt(np.mean((faulty[name] - values) ** 2)))
                worst = max(worst, change / level)
    return worst


def _channels(effect: Effect) -> tuple[str, ...]:
    assert isinstance(effect.reference, ChannelFault)
    return effect.reference.channels


def _seen(effect: Effect, times: float, recordings: Sequence[Recording]) -> bool:
    fault = effect.at(times)
    assert isinstance(fault, ChannelFault)
    for recording in recordings:
        columns = {name: recording.column(name) for name in fault.channels}
        faulty = fault.distort(columns, recording.sampling_hz)
        if not all(
            type(fault).found(name, faulty[name], recording.sampling_hz) for name in fault.channels
        ):
            return False
    return True
