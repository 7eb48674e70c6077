"""Recordings laid beside a twin: the estimation problem; what cannot be used is refused here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.channel import bare
from twin.contract import names_in
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.nominal import checked, with_known
from twin.diagnosis.problem import Between, Measured, Problem
from twin.diagnosis.read_off import ReadOff, read_off
from twin.errors import RecordingError, available
from twin.estimation.likelihood import passes
from twin.mechanisms.scales import range_ends
from twin.model import Twin
from twin.model.linear import LinearModel
from twin.recording import Recording
from twin.signals.noise_floor import noise_floor
from twin.signals.resampling import resample

Array = NDArray[np.float64]

TOLERANCE, DAMPING_TOLERANCE = 0.004, 0.1
"""Prior deviations of masses and stiffnesses, and of dampings, where the user says nothing: a
laboratory's parts are weighed and their stiffnesses measured; a change beyond it is a finding."""

UNKNOWN = 1.0
"""Prior deviation of logarithms where the model's numbers are not known: a factor of three."""

LEAST_SAMPLES = 80
"""Samples that a recording must have for each unknown of a mode: a deviation of a ninth of
the prior's where each sample has a noise as large as the motion."""

LEAST_PERIODS = 4.0
"""Periods of the slowest mode that the recordings must last together: its frequency is then known
to better than its half-power width for a damping of a tenth."""

MOTIONS = ("acc", "vel", "disp", "angle", "rate", "angacc")
"""Quantities that a channel of the structure measures; others may be the laboratory's."""

USED_BAND = 2.56
"""Sampling rate over the highest frequency that an analyser shows."""


@dataclass(frozen=True)
class Prepared:
    """A twin with its estimation problems, and what was done to the recordings.

    Attributes:
        twin: the model, its ground released where a force drives it.
        train, test: recordings to explain, and those on which the result is shown.
        kinds: channel -> quantity.
        faults: of instruments, as the training recordings' samples show them.
        notes: what the reader should know.
    """

    twin: Twin
    train: Problem
    test: Problem
    kinds: Mapping[str, str]
    faults: tuple[ReadOff, ...]
    notes: tuple[str, ...]


def prepare(
    twin: Twin,
    train: Sequence[Recording],
    test: Sequence[Recording],
    tolerance: float = TOLERANCE,
    damping_tolerance: float = DAMPING_TOLERANCE,
    added_mass: Mapping[str, Mapping[str, float]] | None = None,
) -> Prepared:
    """Lay recordings beside a twin.

    Args:
        twin: the model as it stands.
        train: recordings to explain.
        test: recordings that only the result is shown on.
        tolerance: prior deviation of masses and stiffnesses, as a share.
        damping_tolerance: the same of dampings.
        added_mass: source of a recording -> body -> mass bolted on for it [kg].

    Raises:
        RecordingError: no channel of the model's, no excitation, no output, a test that is also
            trained on, or too little data; the message names the file and what there is.
        ModelError: a model without equations of motion.
    """
    if not train or not test:
        raise RecordingError("a diagnosis needs at least one training and one test recording")
    _no_overlap(train, test)
    notes: list[str] = []
    everything = [_of_model(twin, r, notes) for r in (*train, *test)]
    everything = _one_rate(everything, notes)
    inputs = sorted({name for r in everything for name in r.inputs})
    outputs = _common(everything, inputs, notes)
    if "force_ground" in inputs and twin.clamped:
        twin = twin.released()
        notes.append("the ground is driven, so its clamp is taken as undone")
    rate = everything[0].sampling_hz
    model = twin.linear(inputs, outputs, rate / USED_BAND)
    _masses(model, added_mass or {})
    slowest = _slowest(model)
    kinds = {n: r.channel(n).kind for r in everything for n in (*inputs, *outputs) if _has(r, n)}
    measured = [
        _measured(r, model, kinds, slowest, (added_mass or {}).get(r.source, {}), notes)
        for r in everything
    ]
    read = read_off(measured, model, kinds, rate)
    measured = [m for m, _ in read]
    notes += [_hidden(f) for _, found in read for f in found if f.hidden]
    filtered: tuple[Between, ...] = tuple("band_limited" for _ in inputs)
    problems = [
        _scaled(Problem(model, tuple(part), rate, tolerance, damping_tolerance, filtered,
                        np.zeros((len(part), len(model.coordinates)))))
        for part in (measured[: len(train)], measured[len(train) :])
    ]  # fmt: skip
    _enough(problems[0], slowest)
    train_problem, known = with_known(twin, problems[0])
    test_problem = replace(
        problems[1], known=train_problem.known, known_scales=train_problem.known_scales
    )
    notes += [*known, *checked(twin, train_problem)]
    faults = tuple(f for _, found in read[: len(train)] for f in found)
    return Prepared(twin, train_problem, test_problem, kinds, faults, tuple(notes))


def _hidden(found: ReadOff) -> str:
    where = found.fault
    return f"{found.recording}: {where.name} hides {found.hidden} samples of {where.place}"


def _has(recording: Recording, name: str) -> bool:
    return bare(name) in {bare(n) for n in recording.names}


def _no_overlap(train: Sequence[Recording], test: Sequence[Recording]) -> None:
    for t in test:
        for other in train:
            if t.data.shape == other.data.shape and np.array_equal(t.data, other.data):
                raise RecordingError(
                    f"{t.source}: is a test recording and, as {other.source}, a training one, too; "
                    "a test must be unseen"
                )


def _of_model(twin: Twin, recording: Recording, notes: list[str]) -> Recording:
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


def _common(
    recordings: Sequence[Recording], inputs: Sequence[str], notes: list[str]
) -> tuple[str, ...]:
    """Return the outputs that all recordings have."""
    every = list(dict.fromkeys(n for r in recordings for n in r.outputs if n not in inputs))
    common = [n for n in every if all(_has(r, n) for r in recordings)]
    if not common:
        raise RecordingError(
            f"{recordings[0].source}: no output channel that all recordings have; it has "
            f"{available(recordings[0].names)}"
        )
    if left := [n for n in every if n not in common]:
        notes.append(f"not in every recording, so not used: {', '.join(left)}")
    return tuple(common)


def _masses(model: LinearModel, added: Mapping[str, Mapping[str, float]]) -> None:
    there = list(model.bodies)
    for source, masses in added.items():
        for place in masses:
            if place not in there:
                raise RecordingError(
                    f"{source}: no place '{place}' for an added mass; there are {available(there)}"
                )


def _slowest(model: LinearModel) -> float | None:
    """Return the lowest natural frequency that is not a free floating one [Hz], if there is one."""
    w2 = np.linalg.eigvals(np.linalg.solve(model.M, model.K)).real
    held = w2[w2 > 1e-6 * np.max(w2, initial=0.0)]
    return float(np.sqrt(np.min(held)) / (2 * np.pi)) if len(held) else None


def _measured(
    recording: Recording, model: LinearModel, kinds: Mapping[str, str], slowest: float | None,
    mass: Mapping[str, float], notes: list[str],
) -> Measured:  # fmt: skip
    u = np.column_stack(
        [recording.column(n) if _has(recording, n) else np.zeros(recording.samples)
         for n in model.inputs]
    )  # fmt: skip
    y = recording.matrix(model.outputs) - model.rest
    for column, name in enumerate(model.outputs):
        if kinds[name] == "acc":
            offset = _offset(y[:, column], slowest or 1 / recording.duration_s, recording)
            if offset:
                y[:, column] -= offset
                notes.append(f"{recording.source}: {name} has an offset of {offset:.3g} m/s^2")
    floors = [np.array([noise_floor(c) for c in table.T]) for table in (u, y)]
    return Measured(recording.source, u, y, floors[0], floors[1], mass)


def _offset(values: Array, slowest_hz: float, recording: Recording) -> float:
    """Return the offset of an accelerometer, zero where its mean may be the motion's.

    The mean of a true acceleration is the velocity gained over the duration, at most a few times
    that of the slowest mode; only a mean far above that is an offset. Where the ends of the range
    are cut off, blows from one side lose more than those from the other: there its middle tells.
    """
    ends = range_ends(values)
    mean = float(values.mean())
    offset = mean if ends is None else sum(ends) / 2
    possible = 10 * float(np.std(values)) / (2 * np.pi * slowest_hz * recording.duration_s)
    return float(offset) if min(abs(mean), abs(offset)) > possible else 0.0


def _scaled(problem: Problem) -> Problem:
    """Return the problem with the size of its motion: a filter's that trusts the model little."""
    model = problem.model
    size = np.zeros_like(problem.scale)
    gain = np.abs(np.linalg.pinv(model.K) @ model.B)
    for t, r in enumerate(problem.recordings):
        size[t] = gain @ np.sqrt(np.mean(r.u**2, axis=0))
    first = replace(problem, scale=np.maximum(size, np.max(size, initial=1e-12) * 1e-3))
    blank = Hypothesis(first)
    doubtful = np.array([2.0 if u.name.startswith("process") else 0.0 for u in blank.unknowns])
    n = len(model.coordinates)
    try:
        runs = passes(blank, doubtful)
    except ValueError:
        raise RecordingError(
            f"{problem.recordings[0].name}: {available(model.outputs)} cannot tell where the "
            "structure is, for no spring holds it; record a displacement, too"
        ) from None
    scale = np.array([np.sqrt(np.mean(run.x[:, :n] ** 2, axis=0)) for run in runs])
    return replace(problem, scale=np.maximum(scale, 1e-12))


def _enough(problem: Problem, slowest: float | None) -> None:
    modes = max(len(problem.dampings), 1)
    unknowns = 3 * modes
    samples = problem.samples
    seconds = samples * problem.step_s
    needed = LEAST_SAMPLES * unknowns
    least = LEAST_PERIODS / slowest if slowest else 0.0
    if samples < needed or seconds < least:
        names = ", ".join(r.name for r in problem.recordings)
        rate = f" and a slowest mode of {slowest:.3g} Hz" if slowest else ""
        raise RecordingError(
            f"{names}: {samples} samples over {seconds:.3g} s are too little for {unknowns} "
            f"unknowns{rate}; at least {needed} samples and {least:.3g} s are needed"
        )
