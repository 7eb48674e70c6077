"""A size as a share of what the structure, or the reading, has itself."""

from __future__ import annotations

import numpy as np

from twin.mechanisms.mechanism import ChannelFault, Law, Surroundings
from twin.rehearsal.effects import Effect

WHAT = {"N/m": "the stiffness there", "N s/m": "the damping there", "kg": "the mass there"}


def share_of(effect: Effect, times: float, around: Surroundings) -> tuple[float, str] | None:
    """Return a size as a share, and of what: stiffness, mass, elastic force or the reading's RMS.

    Args:
        effect: what is concealed.
        times: its size, as a multiple of its reference.
        around: what is known at its place.
    """
    mechanism = effect.at(times)
    size = effect.size(times)
    if effect.own > 0 and size is not None:
        name = next(n for n in mechanism.values if mechanism.values[n] == size)
        return abs(size) / effect.own, WHAT[type(mechanism).parameters[name].unit]
    if isinstance(mechanism, Law) and not mechanism.memory:
        zero = np.zeros_like(around.drift)
        time = np.arange(len(zero)) / around.sampling_hz % around.duration_s
        force = mechanism.force(around.drift, around.rate, zero, time)
        elastic = around.stiffness * _rms(around.drift)
        return (_rms(force) / elastic, "the elastic force") if elastic > 0 else None
    if isinstance(mechanism, ChannelFault) and len(mechanism.channels) == 1:
        level = _rms(around.reading)
        columns = {mechanism.channels[0]: around.reading}
        changed = mechanism.distort(columns, around.sampling_hz)[mechanism.channels[0]]
        return (_rms(changed - around.reading) / level, "the reading") if level > 0 else None
    return None


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
