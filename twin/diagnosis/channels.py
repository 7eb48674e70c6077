"""Which channels of the recordings are laid beside the twin."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twin.channel import bare
from twin.contract import names_in
from twin.errors import RecordingError, available
from twin.model import Twin
from twin.recording import Recording

MOTIONS = ("acc", "vel", "disp", "angle", "rate", "angacc")
"""Quantities that a channel of the structure measures; others may be the laboratory's."""


def no_overlap(train: Sequence[Recording], test: Sequence[Recording]) -> None:
    """Refuse a test recording that is a training one, too."""
    for t in test:
        for other in train:
            if t.data.shape == other.data.shape and np.array_equal(t.data, other.data):
                raise RecordingError(
                    f"{t.source}: is a test recording and, as {other.source}, a training one, too; "
                    "a test must be unseen"
                )


def of_model(twin: Twin, recording: Recording, notes: list[str]) -> Recording:
    """Return the channels that the model has; a force or a motion that it has not is refused."""
    names = names_in(twin.compile())
    there = set(names["actuator"]) | set(names["sensor"]) | {"acc_ground"}
    kept = [c for c in recording.channels if {c.name, c.element, bare(c.name)} & there]
    lost = [c for c in recording.channels if c not in kept]
    meant = [c.name for c in lost if c.is_input or c.kind in MOTIONS]
    if meant or not kept:
        unknown = (meant or list(recording.names))[0]
        raise RecordingError(
            f"{recording.source}: channel '{unknown}' is not in {twin.source}; it has "
            f"{available(sorted(there))}; `twin convert` with --map leaves out what is not wanted"
        )
    if lost:
        left = ", ".join(c.name for c in lost)
        notes.append(f"{recording.source}: not in the model, so not used: {left}")
    kept_recording = recording.select([c.name for c in kept])
    if not kept_recording.inputs:
        raise RecordingError(
            f"{recording.source}: nothing drives the structure: no force that is not zero "
            f"throughout and no acc_ground as a shake table's; it has {available(recording.names)}"
        )
    return kept_recording


def common(
    recordings: Sequence[Recording], inputs: Sequence[str], notes: list[str]
) -> tuple[str, ...]:
    """Return the outputs that all recordings have."""
    every = list(dict.fromkeys(n for r in recordings for n in r.outputs if n not in inputs))
    common = [n for n in every if all(has(r, n) for r in recordings)]
    if not common:
        raise RecordingError(
            f"{recordings[0].source}: no output channel that all recordings have; it has "
            f"{available(recordings[0].names)}"
        )
    if left := [n for n in every if n not in common]:
        notes.append(f"not in every recording, so not used: {', '.join(left)}")
    return tuple(common)


def has(recording: Recording, name: str) -> bool:
    """Return whether a recording has a channel of that name."""
    return bare(name) in {bare(n) for n in recording.names}
