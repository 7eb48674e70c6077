"""What faults of channels do to trials, and what takes them back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.trials import Trial
from twin.mechanisms.mechanism import ChannelFault, Mechanism

Array = NDArray[np.float64]


def corrected(trial: Trial, mechanisms: Sequence[Mechanism]) -> Trial:
    """Return the trial with all channel faults taken back that can be, and motors' faults done."""
    faults = [m for m in mechanisms if isinstance(m, ChannelFault) and changes_data(m)]
    if not faults:
        return trial
    columns = trial.columns
    for fault in reversed(faults):
        sound = fault.distort if fault.of_motor else fault.undo
        columns = {**columns, **sound(columns, trial.sampling_hz)}
    return trial.with_columns(columns)


def distorted(trial: Trial, mechanisms: Sequence[Mechanism], y: Array) -> Array:
    """Return what the channel faults that can be undone make of outputs, both (samples, m)."""
    columns = replace(trial, y=y).columns
    for fault in mechanisms:
        if isinstance(fault, ChannelFault) and changes_data(fault) and not fault.of_motor:
            columns = {**columns, **fault.distort(columns, trial.sampling_hz)}
    return np.column_stack([columns[name] for name in trial.outputs])


def as_recorded(trial: Trial, mechanisms: Sequence[Mechanism]) -> Array:
    """Return what takes innovations of corrected outputs back to those of recorded ones, (m,)."""
    scale = np.ones(len(trial.outputs))
    for mechanism in mechanisms:
        if isinstance(mechanism, ChannelFault) and mechanism.place in trial.outputs:
            scale[trial.outputs.index(mechanism.place)] *= np.exp(-mechanism.log_volume())
    return scale


def limits_of(mechanisms: Sequence[Mechanism], outputs: Sequence[str]) -> Array:
    """Return the clipping level of every output, infinite where there is none, (m,)."""
    limits = np.full(len(outputs), np.inf)
    for mechanism in mechanisms:
        if isinstance(mechanism, ChannelFault) and mechanism.limit() is not None:
            limits[list(outputs).index(mechanism.place)] = mechanism.limit()
    return limits


def changes_data(mechanism: Mechanism) -> bool:
    """Return whether a mechanism is a fault of a channel that can be taken back."""
    return isinstance(mechanism, ChannelFault) and (
        mechanism.filter_hz() is None and mechanism.limit() is None
    )
