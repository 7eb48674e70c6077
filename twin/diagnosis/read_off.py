"""Faults of instruments that are read off the samples: what they hide is left out, not explained.

A dropout, spikes, the end of a range and a converter's steps need no model to be seen, and no model
of the structure should be asked to follow them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from twin.arrays import filled
from twin.diagnosis.measured import Measured
from twin.mechanisms import vocabulary
from twin.mechanisms.mechanism import ChannelFault
from twin.model.linear import LinearModel
from twin.signals.fault import MOST_HIDDEN
from twin.signals.noise_floor import noise_floor

Array = NDArray[np.float64]

BLOW = 2.0
"""How much farther a spike goes than what a blow through a stiff structure does to an acceleration,
whose mass and instruments are known to better than that."""


@dataclass(frozen=True)
class ReadOff:
    """A fault that one channel of one recording shows.

    Attributes:
        recording: its name.
        fault: with what was read off.
        hidden: how many samples it hides.
        share: of the channel's samples that it hides, or of the noise's power that it is.
    """

    recording: str
    fault: ChannelFault
    hidden: int
    share: float


def faults_in(
    name: str, place: str, kind: str, reading: Array, rate_hz: float, jumps: Array | None = None
) -> tuple[tuple[ReadOff, ...], NDArray[np.bool_]]:
    """Return the faults that a channel's samples show, and which samples they hide, (samples,).

    Args:
        name: of the recording.
        place: the channel.
        kind: its quantity.
        reading: its samples, (samples,).
        rate_hz: samples per second.
        jumps: by how much the inputs make the channel jump, (samples,).
    """
    hidden, found = np.zeros(len(reading), bool), []
    for cls in _read_off():
        if kind not in cls.of_kinds:
            continue
        fault = cls.found(place, reading, rate_hz)
        if fault is None:
            continue
        lost = fault.spoiled(reading)
        if fault.like_jumps and jumps is not None:
            lost &= _jump(reading) > BLOW * jumps
            if not np.any(lost):
                continue
        if np.mean(lost | hidden) > MOST_HIDDEN:
            continue
        hidden |= lost
        floor = max(noise_floor(reading), 1e-300)
        share = float(np.mean(lost)) if np.any(lost) else min(fault.noise() / floor, 1.0) ** 2
        found.append(ReadOff(name, fault, int(np.count_nonzero(lost)), share))
    return tuple(found), hidden


def _jump(x: Array) -> Array:
    """Return how far each sample is from the middle of its neighbours, (samples,)."""
    out = np.zeros(len(x))
    out[1:-1] = np.abs(x[1:-1] - (x[:-2] + x[2:]) / 2)
    return out


def _read_off() -> list[type[ChannelFault]]:
    """Return the faults that are read off: they have nothing to fit, or state a limit."""
    faults = [c for c in vocabulary().values() if issubclass(c, ChannelFault) and not c.of_motor]
    return [c for c in faults if c.on == "channel" and not c.fitted]


def read_off(
    recordings: Sequence[Measured], model: LinearModel, kinds: Mapping[str, str], rate_hz: float
) -> list[tuple[Measured, tuple[ReadOff, ...]]]:
    """Return recordings without what the faults of their outputs hide, and the faults of each.

    Where a channel's range ends in one recording it ends in all that reach so far.

    Args:
        recordings: all of the same instruments.
        model: whose outputs they are.
        kinds: channel -> quantity.
        rate_hz: samples per second.
    """
    out = [_read_off_one(m, model, kinds, rate_hz) for m in recordings]
    limits = {f.fault.place: f.fault for _, found in out for f in found if f.fault.limit()}
    for index, (measured, found) in enumerate(out):
        known = {f.fault.place for f in found}
        for place, fault in limits.items():
            column = model.outputs.index(place)
            reading = recordings[index].y[:, column]
            hidden = fault.spoiled(reading)
            if place in known or not hidden.any() or fault.exceeded(reading):
                continue
            y = np.array(measured.y)
            y[hidden, column] = np.nan
            measured = replace(measured, y=y)
            count = int(np.count_nonzero(hidden))
            found = (*found, ReadOff(measured.name, fault, count, count / len(y)))
        out[index] = measured, found
    return out


def _read_off_one(
    measured: Measured, model: LinearModel, kinds: Mapping[str, str], rate_hz: float
) -> tuple[Measured, tuple[ReadOff, ...]]:
    """Return a recording without what the faults of its outputs hide, and the faults.

    Args:
        measured: the recording.
        model: whose outputs they are.
        kinds: channel -> quantity.
        rate_hz: samples per second.
    """
    y = np.array(measured.y)
    noise = np.array(measured.output_noise)
    faults: list[ReadOff] = []
    through = np.abs(model.Cu + model.Ca @ np.linalg.solve(model.M, model.B))
    pushed = np.column_stack([maximum_filter1d(_jump(u), 3) for u in measured.u.T]) @ through.T
    for column, name in enumerate(model.outputs):
        found, hidden = faults_in(
            measured.name, name, kinds[name], y[:, column], rate_hz, pushed[:, column]
        )
        if not found:
            continue
        faults += found
        y[hidden, column] = np.nan
        floor = noise_floor(filled(y[:, [column]])[:, 0])
        noise[column] = np.hypot(floor, max(f.fault.noise() for f in found))
    if not faults:
        return measured, ()
    return replace(measured, y=y, output_noise=noise), tuple(faults)
