"""A virtual test: an excitation, a place, an analyser and its instruments, run on a twin."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from twin.channel import AXES, GROUND, Channel, bare, implied_kind
from twin.contract import names_in
from twin.errors import ExperimentError, available
from twin.instruments import INSTRUMENT_OF, Instrument, Reading
from twin.laboratory.analyser import Analyser, straight_lines
from twin.laboratory.direct import smoothed
from twin.laboratory.excitation import Excitation, TimeBase, finite
from twin.laboratory.hammer import Hammer
from twin.model import Motion, Twin
from twin.quantity import QUANTITIES
from twin.recording import Recording
from twin.sensor_kinds import channel_kinds

Array = NDArray[np.float64]

STILL = 1e-9
"""A sensor that varies by less than this share of the one that varies most is at rest."""

PLATE = "ground"
"""The base plate of a frame, whose bolts are undone for a shaker that pushes it."""

JUMP_S = 2e-3
"""Pulse as which a jump of dry friction is simulated [s]: its instant is then known to 1/8192 s. At
1024 Hz it would be half a millisecond late on the average, at 50 Hz a sixth of it."""

LONGEST_SETTLING_S = 600.0
"""No shaker runs longer than this before the record begins, unless told to [s]."""


@dataclass(frozen=True)
class Experiment:
    """What is done to the rig and how it is measured.

    Attributes:
        excitation: hammer, shaker signal or ground motion.
        at: where it acts: any actuator by its name, or of a frame floorI or ground; several for
            one shaker each, with signals of their own. A shaker on the ground pushes it through a
            stinger: the base plate is unbolted and slides on its suspension. The stinger is ideal
            (stiff along its axis, without mass, soft across), so the load cell measures what
            enters the ground.
        analyser: sampling, anti-alias filter and length of the record.
        channels: what is recorded, sensors by name and axis; None for the inputs, every
            acceleration that varies, and, of what has no accelerometer, every other sensor; the
            pendulum's angle too, where there is one.
        instruments: by channel name or by kind (force, acc, disp, angle); the name wins. Others
            are ideal, with 24 bits.
        settle_s: time before the record during which a shaker that runs all the time runs
            already [s]. The rig is at rest before.
        ground: axes ("x", "y") along which the ground is shaken, each with a signal of its own: a
            shaker's level is then an acceleration [m/s^2]. A ground motion with no axis is along
            x. Nothing acts at ``at`` then.

    Raises:
        ExperimentError: a negative settling time, no place or an unknown axis.
    """

    excitation: Excitation = field(default_factory=Hammer)
    at: str | tuple[str, ...] = "floor1"
    analyser: Analyser = field(default_factory=Analyser)
    channels: tuple[str, ...] | None = None
    instruments: Mapping[str, Instrument] = field(default_factory=dict)
    settle_s: float = 0.0
    ground: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        finite(self.settle_s, "the settling time", "s")
        if not self.places and not self.shakes_the_ground:
            raise ExperimentError("a test needs a place to act on")
        doubled = [name for name in self.places if self.places.count(name) > 1]
        if doubled:
            raise ExperimentError(f"two shakers act on '{doubled[0]}'")
        unknown = [axis for axis in self.ground if axis not in AXES]
        if unknown:
            raise ExperimentError(f"no axis '{unknown[0]}' of the ground; there are x, y, z")
        object.__setattr__(self, "instruments", MappingProxyType(dict(self.instruments)))

    @property
    def places(self) -> tuple[str, ...]:
        """Where it acts."""
        return (self.at,) if isinstance(self.at, str) else tuple(self.at)

    @property
    def shakes_the_ground(self) -> bool:
        """True where the ground's motion is prescribed and no force is measured."""
        return self.excitation.moves_the_ground or bool(self.ground)

    def inputs(self, twin: Twin) -> tuple[str, ...]:
        """Return the channels that measure what drives a rig.

        Raises:
            ExperimentError: the rig has no such actuator; the message lists those it has.
            ModelError: the ground is to be pushed and cannot slide.
        """
        if self.ground:
            return tuple(f"{GROUND}.{axis}" for axis in self.ground)
        if self.excitation.moves_the_ground:
            return (GROUND,)
        if PLATE in self.places:
            twin.released()  # or it says that there are no bolts to undo
        there = names_in(twin.compile())["actuator"]
        found = []
        for place in self.places:
            name = next((n for n in (f"force_{place}", place) if n in there), None)
            if name is None:
                short = [n.removeprefix("force_") for n in there]
                raise ExperimentError(
                    f"{twin.source}: no '{place}' to act on; there is {available(short)}"
                )
            found.append(name)
        return tuple(found)

    def instrument(self, channel: Channel) -> Instrument:
        """Return the instrument of a channel."""
        usual = INSTRUMENT_OF.get(channel.kind, Instrument())
        return self.instruments.get(channel.name, self.instruments.get(channel.kind, usual))

    def time_base(self, jumps: bool = False) -> TimeBase:
        """Return the instants the test is simulated at.

        Args:
            jumps: whether forces in the rig jump, as dry friction does.
        """
        shortest = self.excitation.shortest_s
        if jumps:
            shortest = JUMP_S if shortest is None else min(shortest, JUMP_S)
        return self.analyser.time_base(shortest, self.settle_s)


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
    rig = twin.compile()
    rubs = np.any(rig.dof_frictionloss) or np.any(rig.tendon_frictionloss)
    base = experiment.time_base(bool(rubs))
    inputs = experiment.inputs(twin)
    histories = {}
    for number, name in enumerate(inputs):
        # the first signal is the same whatever else shakes
        label = f"excitation {experiment.excitation.kind}" + (f" {name}" if number else "")
        histories[name] = experiment.excitation.history(base, stream(seed, repetition, label))
    motion = _simulate(experiment, twin, base, histories, progress)
    # inputs and responses are what a continuous filter in front of the sampler would see
    truth = {name: straight_lines(history) for name, history in histories.items()}
    seen, driven = smoothed(motion.columns, motion.model, histories), {bare(n) for n in inputs}
    truth |= {name: x for name, x in seen.items() if bare(name) not in driven}
    kinds = {**channel_kinds(motion.model), **dict.fromkeys(inputs, "acc")}
    if not experiment.shakes_the_ground:
        kinds = {**kinds, **channel_kinds(twin.compile())}
    channels = {name: Channel(name, implied_kind(name) or kinds[name]) for name in truth}
    names = _named(experiment.channels, truth, twin) or _usual_channels(inputs, channels, truth)
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
    histories: Mapping[str, Array],
    progress: Callable[[float], None] | None,
) -> Motion:
    """Return the motion of the rig at the physics rate."""
    if experiment.shakes_the_ground:
        axes = experiment.ground or ("x",)
        shaken = dict(zip(axes, histories.values(), strict=True))
        return twin.simulate({}, base.rate_hz, base.samples, shaken, progress)
    rig = twin.released() if f"force_{PLATE}" in histories else twin
    return rig.simulate(histories, base.rate_hz, base.samples, progress=progress)


def _named(
    wanted: tuple[str, ...] | None, truth: Mapping[str, Array], twin: Twin
) -> tuple[str, ...]:
    """Return the channels of these names; a bare name and the name with ".x" are one."""
    there = {bare(name): name for name in truth}
    for name in wanted or ():
        if bare(name) not in there:
            raise ExperimentError(
                f"{twin.source}: nothing measures '{name}' in this test; there is "
                f"{available(sorted(truth))}"
            )
    return tuple(dict.fromkeys(there[bare(name)] for name in wanted or ()))


def _usual_channels(
    inputs: tuple[str, ...], channels: Mapping[str, Channel], truth: Mapping[str, Array]
) -> tuple[str, ...]:
    """Return the inputs, the accelerations that vary, and the pendulum's angle.

    Where nothing measures an acceleration: all sensors that vary.
    """
    rest = [name for name in truth if name not in inputs]
    swings = {name: float(np.ptp(truth[name])) for name in rest}
    accelerations = [name for name in rest if channels[name].kind == "acc"]
    chosen = accelerations or rest
    least = STILL * max((swings[name] for name in chosen), default=0.0)
    moving = [name for name in chosen if swings[name] > least]
    angle = [name for name in rest if name == "angle_pendulum"]
    return tuple(dict.fromkeys([*inputs, *moving, *angle]))


def _clipping_notes(readings: Mapping[str, Reading], channels: Mapping[str, Channel]) -> list[str]:
    """Return one sentence for each channel that went beyond its range."""
    return [
        f"{name} was clipped at {reading.full_scale:g} {channels[name].unit} in "
        f"{reading.clipped} of {len(reading.samples)} samples"
        for name, reading in readings.items()
        if reading.clipped
    ]
