"""Recordings and a twin made ready for a diagnosis; what cannot be used is refused here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.contract import names_in
from twin.diagnosis.bench import Bench
from twin.diagnosis.trials import Trial, trial
from twin.errors import ModelError, RecordingError, available
from twin.mechanisms.scales import range_ends
from twin.model import Twin
from twin.recording import Recording
from twin.second_order import SecondOrderModel
from twin.signals.resampling import resample

Array = NDArray[np.float64]

LEAST_SAMPLES = 40
"""Output samples that a recording must have for each mode's unknowns."""

LEAST_PERIODS = 4.0
"""Periods of the slowest mode that the recordings must last together."""


@dataclass(frozen=True)
class Prepared:
    """A twin with training and test bench, and what was done to the recordings."""

    twin: Twin
    train: Bench
    test: Bench
    notes: tuple[str, ...]


def prepare(
    twin: Twin,
    train: Sequence[Recording],
    test: Sequence[Recording],
    added_mass: Mapping[str, Mapping[str, float]] | None = None,
) -> Prepared:
    """Lay recordings beside a twin.

    Args:
        twin: the model as it stands.
        train: recordings to explain.
        test: recordings that only the result is shown on.
        added_mass: source of a recording -> place -> mass bolted on for it [kg].

    Raises:
        RecordingError: channels that the model has not, no excitation, no output, a test that is
            also trained on, or too little data; the message names the file and what there is.
    """
    everything = [*train, *test]
    if not train or not test:
        raise RecordingError("a diagnosis needs at least one training and one test recording")
    _no_overlap(train, test)
    notes: list[str] = []
    for recording in everything:
        _known(twin, recording)
        _excited(recording)
    recordings = _one_rate(everything, notes)
    inputs = sorted({name for r in recordings for name in r.inputs})
    outputs = [n for n in recordings[0].names if _is_output(n, inputs)]
    common = [n for n in outputs if all(n in r.names for r in recordings)]
    if not common:
        raise RecordingError(
            f"{recordings[0].source}: no output channel that all recordings have; it has "
            f"{available(recordings[0].names)}"
        )
    if left := sorted(
        {n for r in recordings for n in r.names if _is_output(n, inputs)} - set(common)
    ):
        notes.append(f"not in every recording, so not used: {', '.join(left)}")
    if "force_ground" in inputs and twin.clamped:
        twin = twin.released()
        notes.append("the ground is driven, so its clamp is taken as undone")
    places = twin.second_order().coordinates
    for source, place in _masses(added_mass):
        if place not in places:
            raise RecordingError(f"{source}: no place '{place}' for an added mass; "
                                 f"there are {available(places)}")  # fmt: skip
    model = twin.second_order()
    slowest = _slowest(model, twin.source)
    recordings = [_without_offset(r, common, slowest, notes) for r in recordings]
    trials = [_trial(r, inputs, common, (added_mass or {}).get(r.source, {})) for r in recordings]
    count = len(train)
    ground = float(twin.compile().body("ground").mass[0])
    benches = tuple(
        Bench(model, tuple(part), ground_mass=ground) for part in (trials[:count], trials[count:])
    )
    _enough(benches[0], slowest)
    return Prepared(twin, benches[0], benches[1], tuple(notes))


def _masses(added: Mapping[str, Mapping[str, float]] | None) -> list[tuple[str, str]]:
    return [(source, place) for source, masses in (added or {}).items() for place in masses]


def _is_output(name: str, inputs: Sequence[str]) -> bool:
    return name.split("_")[0] in ("acc", "disp", "angle") and name not in inputs


def _no_overlap(train: Sequence[Recording], test: Sequence[Recording]) -> None:
    for t in test:
        for other in train:
            same = t.data.shape == other.data.shape and np.array_equal(t.data, other.data)
            if same:
                raise RecordingError(
                    f"{t.source}: is a test recording and, as {other.source}, a training one, too; "
                    "a test must be unseen"
                )


def _known(twin: Twin, recording: Recording) -> None:
    names = names_in(twin.compile())
    there = set(names["actuator"]) | set(names["sensor"]) | {"acc_ground", "force_ground"}
    for name in recording.names:
        if name not in there:
            raise RecordingError(
                f"{recording.source}: channel '{name}' is not in {twin.source}; it has "
                f"{available(sorted(there))}"
            )


def _excited(recording: Recording) -> None:
    if not recording.inputs:
        raise RecordingError(
            f"{recording.source}: nothing drives the frame: no force that is not zero throughout "
            f"and no acc_ground as a shake table's; it has {available(recording.names)}"
        )


def _one_rate(recordings: Sequence[Recording], notes: list[str]) -> list[Recording]:
    """Resample to the lowest rate, and say so."""
    rate = min(r.sampling_hz for r in recordings)
    out = []
    for r in recordings:
        if abs(r.sampling_hz / rate - 1) > 1e-9:
            try:
                data = resample(r.data, r.sampling_hz, rate)
            except ValueError as error:
                raise RecordingError(
                    f"{r.source}: cannot be brought to {rate:g} Hz: {error}"
                ) from None
            notes.append(f"{r.source}: resampled from {r.sampling_hz:g} to {rate:g} Hz")
            r = Recording(rate, r.channels, data, r.source, r.start_s, r.notes)
        out.append(r)
    return out


def _trial(
    recording: Recording, inputs: Sequence[str], outputs: Sequence[str], mass: Mapping[str, float]
) -> Trial:
    columns = {name: recording.column(name) for name in recording.names}
    return trial(recording.source, recording.sampling_hz, columns, inputs, outputs, mass)


def _slowest(model: SecondOrderModel, source: str) -> float:
    """Return the lowest natural frequency that is not a free floating one [Hz]."""
    frequencies = model.undamped_modes().natural_freq
    vibrating = frequencies[frequencies > 1e-3 * np.max(frequencies)]
    if not len(vibrating):
        raise ModelError(
            f"{source}: no spring holds {' or '.join(model.coordinates)}: nothing there vibrates; "
            "give a joint or tendon a stiffness"
        )
    return float(np.min(vibrating))


def _without_offset(
    recording: Recording, outputs: Sequence[str], slowest_hz: float, notes: list[str]
) -> Recording:
    """Take off the offset of an accelerometer where there is one.

    The mean of a true acceleration is the velocity gained over the duration, at most a few times
    that of the slowest mode; only a mean far above that is an offset. Where the ends of the range
    are cut off, blows from one side lose more than those from the other: there its middle tells.
    """
    data = recording.data.copy()
    for name in outputs:
        if not name.startswith("acc"):
            continue
        column = recording.names.index(name)
        values = data[:, column]
        rms = float(np.sqrt(np.mean(values**2)))
        ends = range_ends(values)
        mean = float(values.mean())
        offset = mean if ends is None else sum(ends) / 2
        possible = 10 * rms / (2 * np.pi * slowest_hz * recording.duration_s)
        if min(abs(mean), abs(offset)) > possible:
            notes.append(f"{recording.source}: {name} has an offset of {offset:.3g} m/s^2")
            data[:, column] = values - offset
    return replace(recording, data=data)


def _enough(bench: Bench, slowest: float) -> None:
    modes = len(bench.model.coordinates)
    seconds = sum(t.samples / t.sampling_hz for t in bench.trials)
    needed = LEAST_SAMPLES * 6 * modes
    names = ", ".join(t.name for t in bench.trials)
    if bench.samples < needed or seconds * slowest < LEAST_PERIODS:
        raise RecordingError(
            f"{names}: {bench.samples} samples over {seconds:.3g} s are too little for "
            f"{3 * modes} unknowns and a slowest mode of {slowest:.3g} Hz; "
            f"at least {needed} samples and {LEAST_PERIODS / slowest:.3g} s are needed"
        )
