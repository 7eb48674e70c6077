"""What a recording holds, and what may be wrong with it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from twin.errors import RecordingError
from twin.recording import Recording
from twin.signals.channel_faults import channel_faults
from twin.signals.fault import Fault
from twin.signals.frf import measured_response
from twin.signals.pair_faults import PairFault, clock, identical, reversed_polarity


@dataclass(frozen=True)
class ChannelInspection:
    """One channel.

    Attributes:
        title: name and SI unit.
        role: input, output, or silent (a force that is zero throughout).
        rms: root mean square, in its unit.
        mean: its mean.
        peak: largest magnitude.
        coherence: with all inputs, mean over the lines that they excite, 0 to 1; None for an input
            and where too few blocks tell.
        faults: what is wrong with it.
    """

    title: str
    role: str
    rms: float
    mean: float
    peak: float
    coherence: float | None
    faults: tuple[Fault, ...]


@dataclass(frozen=True)
class RecordingInspection:
    """A recording, its channels and its pairs of channels."""

    recording: Recording
    channels: tuple[ChannelInspection, ...]
    pairs: tuple[tuple[str, str, PairFault], ...]

    def warnings(self) -> tuple[str, ...]:
        """Return one line for each fault: the channel and what is wrong with it."""
        lines = [
            f"{name}: {fault.name.replace('_', ' ')}: {fault.words}"
            for name, channel in zip(self.recording.names, self.channels, strict=True)
            for fault in channel.faults
        ]
        return (*lines, *(f"{b}: against {a}: {fault.words}" for a, b, fault in self.pairs))

    def as_json(self) -> dict[str, Any]:
        """Return everything as JSON."""
        recording = self.recording
        return {
            "source": recording.source,
            "sampling_hz": recording.sampling_hz,
            "samples": recording.samples,
            "duration_s": recording.duration_s,
            "start_s": recording.start_s,
            "channels": [
                {
                    "name": channel.name,
                    "unit": channel.unit,
                    "kind": channel.kind,
                    "role": found.role,
                    "rms": found.rms,
                    "mean": found.mean,
                    "peak": found.peak,
                    "coherence": found.coherence,
                    "faults": [
                        {"name": f.name, "size": float(f.size), "words": f.words,
                         "samples": [list(s) for s in f.samples]}
                        for f in found.faults
                    ],
                }
                for channel, found in zip(recording.channels, self.channels, strict=True)
            ],
            "pairs": [
                {"channels": [a, b], "name": f.name, "size": float(f.size), "words": f.words}
                for a, b, f in self.pairs
            ],
            "notes": list(recording.notes),
        }  # fmt: skip


def inspect(recording: Recording) -> RecordingInspection:
    """Look at every channel of a recording, and at pairs of them.

    A force and an acceleration are of one point where their names end alike (force_floor1,
    acc_floor1); only of those is the sign compared.
    """
    inputs, outputs = recording.inputs, recording.outputs
    told = _coherence(recording)
    channels = []
    for channel in recording.channels:
        x = recording.column(channel.name)
        role = "input" if channel.name in inputs else "silent"
        channels.append(
            ChannelInspection(
                channel.title,
                "output" if channel.name in outputs else role,
                float(np.sqrt(np.mean(x**2))),
                float(np.mean(x)),
                float(np.max(np.abs(x))),
                told.get(channel.name),
                channel_faults(x, recording.sampling_hz, channel.kind),
            )
        )
    return RecordingInspection(recording, tuple(channels), tuple(_pairs(recording)))


def _pairs(recording: Recording) -> list[tuple[str, str, PairFault]]:
    rate, found = recording.sampling_hz, []
    columns = [(c, recording.column(c.name)) for c in recording.channels]
    for i, (a, x) in enumerate(columns):
        for b, y in columns[i + 1 :]:
            same = identical(x, y)
            if same is None and a.kind == b.kind == "acc":
                same = clock(x, y, rate)
            if same is not None:
                found.append((a.name, b.name, same))
        end = a.name.partition("_")[2]
        for b, y in columns:
            at_one_point = end and b.name.partition("_")[2] == end
            if a.kind == "force" and b.kind == "acc" and at_one_point:
                turned = reversed_polarity(x, y, rate)
                if turned is not None:
                    found.append((a.name, b.name, turned))
    return found


def _coherence(recording: Recording) -> dict[str, float]:
    """Return each output's mean coherence with the inputs; nothing where it cannot be told."""
    inputs, outputs = recording.inputs, recording.outputs
    if not inputs or not outputs:
        return {}
    try:
        found = measured_response(
            [(recording.matrix(inputs), recording.matrix(outputs))], recording.sampling_hz
        )
    except RecordingError:
        return {}
    use = found.excited(1e-2)
    if found.coherence is None or not np.any(use):
        return {}
    mean = np.mean(found.coherence[use], axis=0)
    return {n: float(m) for n, m in zip(outputs, mean, strict=True) if np.isfinite(m)}
