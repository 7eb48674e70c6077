"""Recordings laid beside a twin: the estimation problem; what cannot be used is refused here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from twin.contract import names_in
from twin.diagnosis.band import USED_BAND, Banded, banded, one_rate
from twin.diagnosis.beginning import start_of
from twin.diagnosis.channels import common, has, no_overlap, of_model
from twin.diagnosis.drawing import LEAST
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.input_band import within_band
from twin.diagnosis.large_motion import with_large_motion
from twin.diagnosis.measured import Measured
from twin.diagnosis.nominal import checked, with_known
from twin.diagnosis.order import in_words, read_order
from twin.diagnosis.problem import Between, Problem
from twin.diagnosis.read_off import ReadOff, read_off
from twin.diagnosis.shown import in_shown_band, inputs_of, refuse_what_moves_nothing
from twin.errors import RecordingError, available
from twin.estimation.likelihood import passes
from twin.mechanisms.scales import range_ends
from twin.model import Twin
from twin.model.linear import LinearModel
from twin.recording import Recording
from twin.signals.noise_floor import noise_floor

Array = NDArray[np.float64]

DAMPING_TOLERANCE = 0.1
"""Prior deviation of dampings where the user says nothing; a change beyond it is a finding."""

UNKNOWN = 1.0
"""Prior deviation of logarithms where the model's numbers are not known: a factor of three."""

LEAST_SAMPLES = 80
"""Samples that a recording must have for each unknown of a mode: a deviation of a ninth of
the prior's where each sample has a noise as large as the motion."""

LEAST_PERIODS = 4.0
"""Periods of the slowest mode that the recordings must last together: its frequency is then known
to better than its half-power width for a damping of a tenth."""

HALF_POWER = 0.05
"""Half-power width of a mode over its frequency, that of a damping ratio of 2.5 %."""

HARDLY_KNOWN = 2 * HALF_POWER
"""Tolerance from which a shaken structure's numbers count as hardly known: its frequencies then
scatter by the half-power width."""

SEEN_ABOVE = 0.02
"""Prior deviation of the logarithm of a noise level that a thousand samples above the band show,
1 / sqrt(2 N)."""

SHAKEN = (
    "without a measured force masses, stiffnesses and dampings are known up to a common factor "
    "only: their total is the model's"
)


@dataclass(frozen=True)
class Prepared:
    """A twin with its estimation problems, and what was done to the recordings.

    Attributes:
        twin: the model, its ground released where a force drives it.
        train, test: recordings to explain, and those on which the result is shown.
        kinds: channel -> quantity.
        faults: of instruments, as the training recordings' samples show them.
        notes: what the reader should know.
        shaken: whether the ground alone drives the structure.
        simulated: whether hypotheses are judged by their simulation: the ground alone shakes a
            structure whose numbers are hardly known.
        known: values by name from which a calibration may begin; none where none are.
    """

    twin: Twin
    train: Problem
    test: Problem
    kinds: Mapping[str, str]
    faults: tuple[ReadOff, ...]
    notes: tuple[str, ...]
    shaken: bool = False
    simulated: bool = False
    known: Mapping[str, float] = field(default_factory=dict)


def prepare(
    twin: Twin,
    train: Sequence[Recording],
    test: Sequence[Recording],
    tolerance: float | None = None,
    damping_tolerance: float = DAMPING_TOLERANCE,
    added_mass: Mapping[str, Mapping[str, float]] | None = None,
) -> Prepared:
    """Lay recordings beside a twin.

    Args:
        twin: the model as it stands.
        train: recordings to explain.
        test: recordings that only the result is shown on.
        tolerance: prior deviation of masses and stiffnesses, as a share; found from the recordings
            where nothing is said.
        damping_tolerance: the same of dampings.
        added_mass: source of a recording -> body -> mass bolted on for it [kg].

    Raises:
        RecordingError: no channel of the model's, no excitation, no output, a test that is also
            trained on, or too little data; the message names the file and what there is.
        ModelError: a model without equations of motion.
    """
    if not train or not test:
        raise RecordingError("a diagnosis needs at least one training and one test recording")
    no_overlap(train, test)
    told, tolerance = tolerance is not None, LEAST if tolerance is None else tolerance
    notes: list[str] = []
    everything = [of_model(twin, r, notes) for r in (*train, *test)]
    everything = one_rate(everything, min(r.sampling_hz for r in everything), notes)
    inputs = sorted({name for r in everything for name in r.inputs})
    outputs = common(everything, inputs, notes)
    if "force_ground" in inputs and twin.clamped:
        twin = twin.released()
        notes.append("the ground is driven, so its clamp is taken as undone")
    shaken = not any(name in inputs for name in names_in(twin.compile())["actuator"])
    band = Banded(tuple(everything), {}, ())
    simulated = shaken and tolerance >= HARDLY_KNOWN
    if shaken:
        notes.append(SHAKEN)
    if simulated:
        band = banded(everything, len(train), tolerance, 3 * LEAST_SAMPLES * len(outputs))
    everything, rate = list(band.recordings), band.recordings[0].sampling_hz
    notes += band.notes
    model = twin.linear(inputs, outputs, rate / USED_BAND)
    refuse_what_moves_nothing(everything, model)
    if not simulated:
        everything = in_shown_band(everything, model, notes)
        rate = everything[0].sampling_hz
    _masses(model, added_mass or {})
    slowest = _slowest(model)
    kinds = {n: r.channel(n).kind for r in everything for n in (*inputs, *outputs) if has(r, n)}
    measured = [
        _measured(r, model, kinds, slowest, (added_mass or {}).get(r.source, {}), notes)
        for r in everything
    ]
    if simulated:
        measured = [_in_band(m, band, model, rate, notes) for m in measured]
    read = read_off(measured, model, kinds, rate)
    commanded = [name in model.driven for name in model.inputs]
    measured = [m if simulated else within_band(m, rate, commanded) for m, _ in read]
    notes += [hidden_in_words(f) for _, found in read for f in found if f.hidden]
    filtered: tuple[Between, ...] = tuple("band_limited" for _ in inputs)
    problems = [
        _scaled(Problem(model, tuple(part), rate, tolerance, damping_tolerance, filtered,
                        np.zeros((len(part), len(model.coordinates))), told=told))
        for part in (measured[: len(train)], measured[len(train) :])
    ]  # fmt: skip
    _enough(problems[0], slowest)
    begun: Mapping[str, float] = {}
    if not simulated:
        problems, begun = with_large_motion(twin, problems)
    train_problem, known = with_known(twin, problems[0])
    test_problem = replace(
        problems[1], known=train_problem.known, known_scales=train_problem.known_scales
    )
    notes += [*known, *checked(twin, train_problem, simulated)]
    faults = tuple(f for _, found in read[: len(train)] for f in found)
    return Prepared(
        twin, train_problem, test_problem, kinds, faults, tuple(notes), shaken, simulated, begun
    )


def _in_band(
    measured: Measured, band: Banded, model: LinearModel, rate: float, notes: list[str]
) -> Measured:
    """Return a recording with the noise that its inputs show above the band, outputs in order."""
    y, noise, order = (
        measured.y,
        measured.output_noise,
        read_order(model, measured.u, measured.y, rate),
    )
    if order != tuple(range(y.shape[1])):
        notes.append(in_words(measured.name, model.outputs, order))
        y, noise = y[:, order], noise[list(order)]
    measured = replace(measured, y=y, output_noise=noise)
    if measured.name not in band.input_noise:
        return measured
    seen = band.input_noise[measured.name]
    return replace(measured, input_noise=seen, input_deviation=SEEN_ABOVE)


def hidden_in_words(found: ReadOff) -> str:
    """Say how many samples of which channel a fault hides."""
    where = found.fault
    return f"{found.recording}: {where.name} hides {found.hidden} samples of {where.place}"


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
    u = inputs_of(recording, model)
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
    n = len(model.coordinates)
    try:
        runs = passes(blank, start_of(blank))
    except np.linalg.LinAlgError:
        raise RecordingError(
            f"{problem.recordings[0].name}: {available(model.outputs)} cannot tell where the "
            "structure is, for no spring holds it; record a displacement, too"
        ) from None
    scale = np.array([np.sqrt(np.mean(run.moved()[0][:, :n] ** 2, axis=0)) for run in runs])
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
