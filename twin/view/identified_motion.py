"""How the identified structure moves under the recorded inputs, beside how the true one does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import TwinError
from twin.identification.result import Identification
from twin.model import Motion, Twin
from twin.recording import Recording
from twin.signals.resampling import resample
from twin.state_space import StateSpace
from twin.view.comparison import place_of
from twin.view.scene import LONGEST_MOTION_S

Array = NDArray[np.float64]

FINER = 8
"""Steps in a sample of the recording: forces are band-limited between the samples."""


@dataclass(frozen=True)
class FloorMotion:
    """Displacement of ground and floors, from below.

    Attributes:
        rate_hz: samples per second.
        x: [m], (samples, levels).
    """

    rate_hz: float
    x: Array


def identified_motion(result: Identification) -> FloorMotion | None:
    """Return how the identified M, R, K move under the first recording's forces.

    None where they were not identified, or where something else drives than forces on floors.
    """
    model = result.second_order
    if model is None:
        return None
    places = [place_of(name) for name in model.coordinates]
    driven = {name: place_of(name) for name in result.inputs if name.startswith("force_")}
    floors = sorted((p for p in places if p.startswith("floor")), key=lambda p: int(p[5:]))
    if len(driven) != len(result.inputs) or len(floors) != len(places):
        return None
    if not set(driven.values()) <= set(places):
        return None
    recording = result.recordings[0]
    forces = _finer(recording, tuple(n for n in driven if n in recording.names))
    n = len(places)
    B = np.zeros((2 * n, len(forces)))
    for column, name in enumerate(forces):
        push = np.zeros(n)
        push[places.index(driven[name])] = 1.0
        B[n:, column] = np.linalg.solve(model.M, push)
    C = np.hstack([np.eye(n), np.zeros((n, n))])
    rate = FINER * recording.sampling_hz
    plant = StateSpace(model.state_matrix(), B, C, np.zeros((n, len(forces))), None)
    moved = plant.held(1 / rate).simulate(np.column_stack(list(forces.values())))
    order = [places.index(floor) for floor in floors]
    return FloorMotion(rate, np.hstack([np.zeros((len(moved), 1)), moved[:, order]]))


def true_motion(result: Identification, truth: Twin) -> Motion | None:
    """Return how the true twin moves under the first recording's inputs; None where it cannot."""
    recording = result.recordings[0]
    inputs = _finer(recording, tuple(n for n in result.inputs if n in recording.names))
    ground = inputs.pop("acc_ground", None)
    samples = (
        len(next(iter(inputs.values()))) if inputs else len(ground if ground is not None else [])
    )
    if not samples:
        return None
    rate = FINER * recording.sampling_hz
    try:
        return truth.simulate(inputs, rate, samples, ground_acceleration=ground)
    except TwinError:
        return None


def _finer(recording: Recording, names: tuple[str, ...]) -> dict[str, Array]:
    rate = recording.sampling_hz
    most = round(LONGEST_MOTION_S * rate)
    return {name: resample(recording.column(name)[:most], rate, FINER * rate) for name in names}
