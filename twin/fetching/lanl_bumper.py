"""The three-storey frame of Los Alamos: a base on rails, three floors, a bumper at the top."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from twin.errors import RecordingError
from twin.fetching.matlab import variable
from twin.recording import Recording

RATE_HZ = 320.0
GRAVITY = 9.80665
CHANNELS = ("force_ground", "acc_ground", "acc_floor1", "acc_floor2", "acc_floor3")
KEPT = 4
"""Tests of each state that are written, of ten."""
NOTE = (
    "the file names no units: the force is taken in N and accelerations in g, 320 Hz (LA-14393); "
    "states 1 to 9 change mass or stiffness, 10 to 17 have the bumper"
)


def recordings(members: Mapping[str, bytes]) -> list[Recording]:
    """Return the first tests of each state, "lanl_state14_1.csv" and so on.

    Raises:
        RecordingError: arrays of another shape than (8192, 5, 170) and 170 states.
    """
    data = variable(members, "data3SS.mat", "dataset")
    states = variable(members, "data3SS.mat", "states").ravel().astype(int)
    if data.ndim != 3 or data.shape[1] != len(CHANNELS) or data.shape[2] != len(states):
        raise RecordingError(
            f"data3SS.mat: 'dataset' has the shape {data.shape} for {len(states)} states; "
            f"expected (samples, {len(CHANNELS)}, {len(states)})"
        )
    scale = np.array([1.0, *(GRAVITY,) * 4])
    out = []
    for state in sorted(set(states.tolist())):
        for number, index in enumerate(np.flatnonzero(states == state)[:KEPT], start=1):
            values = data[:, :, index] * scale
            columns = dict(zip(CHANNELS, values.T, strict=True))
            name = f"lanl_state{state:02d}_{number}.csv"
            out.append(Recording.build(RATE_HZ, columns, name, notes=(NOTE,)))
    return out
