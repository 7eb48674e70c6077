"""A virtual test: an excitation, a place, an analyser and its instruments, run on a twin."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from twin.channel import Channel, implied_kind
from twin.errors import ExperimentError, available
from twin.instruments import INSTRUMENT_OF, Instrument, Reading
from twin.laboratory.analyser import Analyser, straight_lines
from twin.laboratory.excitation import Excitation, TimeBase, finite
from twin.laboratory.hammer import Hammer
from twin.model import Motion, Twin
from twin.quantity import QUANTITIES
from twin.recording import Recording
from twin.sensor_kinds import channel_kinds

Array = NDArray[np.float64]

LONGEST_SETTLING_S = 600.0
"""No shaker runs longer than this before the record begins, unless told to [s]."""


@dataclass(frozen=True)
class Experiment:
    """What is done to the rig and how it is measured.

    Attributes:
        excitation: hammer, shaker signal or ground motion.
        at: where it acts: floorI, or ground. A shaker on the ground pushes it through a stinger:
            the base plate is unbolted and slides on its suspension. The stinger is ideal (stiff
            along its axis, without mass, soft across), so the load cell measures what enters the
            ground. A ground motion acts at the ground whatever is said here.
        analyser: sampling, anti-alias filter and length of the record.
        channels: what is recorded; None for the input, the acceleration of every floor, that of
            the ground where it is free, and the pendulum's angle where there is one.
        instruments: by channel name or by kind (force, acc, disp, angle); the name wins. Others
            are ideal, with 24 bits.
        settle_s: time before the record during which a shaker that runs all the time runs
            already [s]. The rig is at rest before.

    Raises:
        ExperimentError: a negative settling time.
    """

    excitation: Excitation = field(default_factory=Hammer)
    at: str = "floor1"
    analyser: Analyser = field(default_factory=Analyser)
    channels: tuple[str, ...] | None = None
    instruments: Mapping[str, Instrument] = field(default_factory=dict)
    settle_s: float = 0.0

    def __post_init__(self) -> None:
        finite(self.settle_s, "the settling time", "s")
        object.__setattr__(self, "instruments", MappingProxyType(dict(self.instruments)))

    @property
    def input(self) -> str:
        """The channel that measures what drives the rig."""
        return "acc_ground" if self.excitation.moves_the_ground else f"force_{self.at}"

    def instrument(self, channel: Channel) -> Instrument:
        """Return the instrument of a channel."""
        usual = INSTRUMENT_OF.get(channel.kind, Instrument())
        return self.instruments.get(channel.name, self.instruments.get(channel.kind, usual))

    def time_base(self) -> TimeBase:
        """Return the instants the test is simulated at."""
        return self.analyser.time_base(self.excitation.shortest_s, self.settle_s)


@dataclass(frozen=True)
class Performance:
    """A test that was carried out.

    Attributes:
        recording: what the analyser stored.
        motion: of the rig, lead-in and lead-out included.
        start_s: time of the motion's first sample in the recording's time [s].
    """

    recording: Recording
    motion: Motion
    start_s: float


def run(
    experiment: Experiment,
    twin: Twin,
    seed: int = 0,
    repetition: int = 0,
    progress: Callable[[float], None] | None = None,
) -> Recording:
    """Carry out a test on a twin and return its recording; see ``perform``."""
    return perform(experiment, twin, seed, repetition, progress).recording


def perform(
    experiment: Experiment,
    twin: Twin,
    seed: int = 0,
    repetition: int = 0,
    progress: Callable[[float], None] | None = None,
) -> Performance:
    """Carry out a test on a twin.

    Args:
        experiment: what is done.
        twin: the rig.
        seed: the same seed gives the same recording, bit for bit.
        repetition: number of the repetition: other noise, another realisation of random shaking.
        progress: told the share of the simulation that is done, 0 to 1.

    Returns:
        The recording in SI units, whose notes name clipped channels, and the rig's motion.

    Raises:
        ExperimentError: the rig has no such place or channel, or the excitation does not fit.
    """
    base = experiment.time_base()
    rng = stream(seed, repetition, f"excitation {experiment.excitation.kind}")
    history = experiment.excitation.history(base, rng)
    truth, motion = _simulate(experiment, twin, base, history, progress)
    # response and input alike are what a continuous filter in front of the sampler would see
    truth[experiment.input] = straight_lines(truth[experiment.input])
    kinds = {experiment.input: _input_kind(experiment), **channel_kinds(motion.model)}
    channels = {name: Channel(name, implied_kind(name) or kinds[name]) for name in truth}
    names = experiment.channels or _usual_channels(experiment, channels, truth)
    for name in names:
        if name not in truth:
            raise ExperimentError(
                f"{twin.source}: nothing measures '{name}' in this test; there is "
                f"{available(sorted(truth))}"
            )
    for name in experiment.instruments:
        if name not in truth and name not in QUANTITIES and implied_kind(name) is None:
            raise ExperimentError(
                f"{twin.source}: an instrument for '{name}', which is no kind "
                f"({available(QUANTITIES)}) and no channel; there is {available(sorted(truth))}"
            )
    readings = {}
    for name in names:
        instrument = experiment.instrument(channels[name])
        samples = experiment.analyser.sample(instrument.sense(truth[name], base.rate_hz), base)
        readings[name] = instrument.digitise(samples, stream(seed, repetition, name))
    recording = Recording.build(
        experiment.analyser.sampling_hz,
        {name: reading.samples for name, reading in readings.items()},
        source=f"virtual {experiment.excitation.kind} test of {Path(twin.source).name}",
        notes=tuple(_clipping_notes(readings, channels)),
        kinds={name: channel.kind for name, channel in channels.items()},
    )
    return Performance(recording, motion, base.first / base.rate_hz)


def settling_time(rig: Twin, left: float = 1e-4) -> float:
    """Return how long a motion of the rig takes to die out to the share ``left`` [s].

    It is that of the slowest mode; a motion that never dies out (a ground that floats) counts as
    one that needs ten minutes, the longest time returned.
    """
    poles = np.linalg.eigvals(rig.linearisation().generalised.state_matrix())
    slowest = float(np.min(-poles.real))
    return min(-math.log(left) / slowest, LONGEST_SETTLING_S) if slowest > 0 else LONGEST_SETTLING_S


def stream(seed: int, repetition: int, name: str) -> np.random.Generator:
    """Return random numbers of their own for each name: one channel more changes no other."""
    return np.random.default_rng(np.random.SeedSequence([seed, repetition, *name.encode()]))


def _simulate(
    experiment: Experiment,
    twin: Twin,
    base: TimeBase,
    history: Array,
    progress: Callable[[float], None] | None,
) -> tuple[dict[str, Array], Motion]:
    """Return every channel there is at the physics rate, the input's among them, and the motion."""
    if experiment.excitation.moves_the_ground:
        motion = twin.simulate({}, base.rate_hz, base.samples, history, progress)
        return {experiment.input: history, **motion.columns}, motion
    places = ("ground", *twin.floors)
    if experiment.at not in places:
        raise ExperimentError(
            f"{twin.source}: no '{experiment.at}' to act on; there is {available(places)}"
        )
    rig = twin.released() if experiment.at == "ground" else twin
    forces = {experiment.input: history}
    motion = rig.simulate(forces, base.rate_hz, base.samples, progress=progress)
    return {**forces, **motion.columns}, motion


def _input_kind(experiment: Experiment) -> str:
    return "acc" if experiment.excitation.moves_the_ground else "force"


def _usual_channels(
    experiment: Experiment, channels: Mapping[str, Channel], truth: Mapping[str, Array]
) -> tuple[str, ...]:
    """Return the input, the accelerations of what can move, and the pendulum's angle."""
    moving = [name for name, x in truth.items() if channels[name].kind == "acc" and np.any(x)]
    angle = ["angle_pendulum"] if "angle_pendulum" in truth else []
    return tuple(dict.fromkeys([experiment.input, *moving, *angle]))


def _clipping_notes(readings: Mapping[str, Reading], channels: Mapping[str, Channel]) -> list[str]:
    """Return one sentence for each channel that went beyond its range."""
    return [
        f"{name} was clipped at {reading.full_scale:g} {channels[name].unit} in "
        f"{reading.clipped} of {len(reading.samples)} samples"
        for name, reading in readings.items()
        if reading.clipped
    ]
