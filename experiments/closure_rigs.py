"""The rigs of the closure test: three structures, and their recordings with a mechanism."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.formats import write_recording
from twin.instruments import Instrument
from twin.laboratory import Analyser, Experiment, Hammer, RandomShaking, run
from twin.mechanisms import places, vocabulary
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Mechanism
from twin.model import Twin
from twin.model.linear import LinearModel
from twin.recording import Recording

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Structure:
    """A shipped model with its tests.

    Attributes:
        model: its name.
        drives: actuators that shake, all at once.
        band_hz: of the shaking.
        rms_n: of the shaking; the hammer's peak is twenty times as high. What twists is shaken so
            gently, a tenth of a millimetre, that its geometry adds less to its motion than noise.
        sampling_hz, duration_s: of the recordings; no mode lies where the analyser's filter falls
            off, from 1/2.56 to 0.61 of the rate: what it aliases there is not what the mode does.
        blow_s: contact of the hammer, whose tip is chosen for the band: its spectrum ends, at
            1.5 / blow_s, before the analyser aliases any of it onto modes.
        places: where a mechanism of each kind is put; others take the first place there is.
        hidden: the actuator, and its port, that stand for a force nobody measures.
        tuned: above which mode an appendage resonates: along a beam the first one's shape tells
            nothing of its place, for a lighter one nearer to the tip pulls alike.
    """

    model: str
    drives: tuple[str, ...]
    band_hz: tuple[float, float]
    rms_n: float
    sampling_hz: float
    duration_s: float
    places: dict[str, str]
    hidden: tuple[str, str]
    blow_s: float = 0.008
    tuned: int = 0


STRUCTURES = {
    "chain": Structure(
        "two_storey_lumped",
        ("force_floor1", "force_floor2"),
        (0.5, 12.0),
        0.4,
        128.0,
        24.0,
        {"drift": "storey2", "motion": "floor2", "body": "floor1", "base": "ground"},
        ("force_floor2", "floor2"),
    ),
    "portal": Structure(
        "portal_3d",
        ("force_floor1_x", "force_floor2_y"),
        (0.5, 20.0),
        0.03,
        128.0,
        24.0,
        {
            "drift": "storey1_column3_x",
            "motion": "floor2.x",
            "body": "floor2_load1",
            "base": "ground.y",
        },
        ("force_floor2_x", "force_floor2_x.x"),
    ),
    "cantilever": Structure(
        "cantilever",
        ("force_mid", "force_tip"),
        (0.5, 70.0),
        0.03,
        192.0,
        16.0,
        {"drift": "hinge3", "motion": "acc_mid", "body": "link6", "base": "ground"},
        ("force_tip", "acc_tip"),
        blow_s=0.02,
        tuned=1,
    ),
}
NOISE = 0.005
FINE = 32
"""Steps of the simulation to a sample: its straight lines have images, which move fast modes by
some 1/FINE^2 of what is read; that is below the noise."""

HIDDEN_SHARE = 0.3
"""RMS of the force that nobody measures, over that of a shaker."""

NOT_ASKED = ("restoring_force", "sensor_unexplained", "pendulum_friction")
"""What stands for no physics of its own, and what needs a hinge that a motor drives."""


def linear_of(structure: Structure) -> LinearModel:
    """Return the linear equations of a structure with its shakers and all it records."""
    return _linear(structure.model)


@lru_cache(maxsize=4)
def _linear(model: str) -> LinearModel:
    structure, twin = _structure(model), Twin.load(model)
    outputs = run(_test(structure, RandomShaking(1.0, structure.band_hz), 0.5), twin).outputs
    return twin.linear(structure.drives, outputs)


@lru_cache(maxsize=4)
def shaken(model: str) -> Recording:
    """Return a recording of a structure with all shakers."""
    structure = _structure(model)
    shaking = RandomShaking(structure.rms_n, structure.band_hz)
    return run(_test(structure, shaking, structure.duration_s), Twin.load(model))


def _structure(model: str) -> Structure:
    return next(s for s in STRUCTURES.values() if s.model == model)


def mechanisms_of(structure: Structure) -> list[str]:
    """Return the vocabulary that has a place on a structure."""
    model = linear_of(structure)
    kinds = dict.fromkeys(model.outputs, "acc")
    return [
        name
        for name, cls in vocabulary().items()
        if name not in NOT_ASKED and places(cls, model, kinds)
    ]


def place_of(structure: Structure, name: str) -> str:
    """Return where a mechanism is put."""
    cls, model = vocabulary()[name], linear_of(structure)
    if issubclass(cls, Disturbance):
        return structure.hidden[1]
    every = places(cls, model, dict.fromkeys(model.outputs, "acc"))
    wanted = structure.places.get(cls.on)
    return wanted if wanted in every else every[min(1, len(every) - 1)]


def _test(
    structure: Structure, excitation: RandomShaking | Hammer, duration_s: float,
    at: tuple[str, ...] = (), channels: tuple[str, ...] | None = None,
) -> Experiment:  # fmt: skip
    noisy = Instrument(noise_fraction=NOISE)
    return Experiment(
        excitation,
        at or structure.drives,
        Analyser(structure.sampling_hz, duration_s, physics_hz=FINE * structure.sampling_hz),
        channels,
        {"acc": noisy, "force": noisy},
    )


def record(
    structure: Structure, mechanism: Mechanism | None, folder: Path
) -> tuple[list[Path], list[Path]]:
    """Write recordings of a twin that has a mechanism; return those to train and to test on."""
    twin = Twin.load(structure.model)
    hidden = isinstance(mechanism, Disturbance)
    if mechanism is not None and not hidden:
        twin = twin.including(mechanism)
    rms, band = structure.rms_n, structure.band_hz
    peak = 20 * rms
    tests = {
        "train_1": (RandomShaking(rms, band), structure.drives),
        "train_2": (Hammer(structure.blow_s, peak), structure.drives[:1]),
        "train_3": (RandomShaking(0.4 * rms, band), structure.drives),
        "test_1": (RandomShaking(0.7 * rms, band), structure.drives),
    }
    paths = []
    for number, (name, (excitation, at)) in enumerate(tests.items()):
        recording = _recorded(structure, twin, excitation, at, number, hidden)
        if isinstance(mechanism, ChannelFault) and not mechanism.of_motor:
            columns = {channel: recording.column(channel) for channel in recording.names}
            faulty = mechanism.distort(columns, recording.sampling_hz)
            data = np.column_stack([faulty[channel] for channel in recording.names])
            recording = replace(recording, data=data)
        paths.append(write_recording(recording, folder / f"{name}.csv"))
    return paths[:3], paths[3:]


def _recorded(
    structure: Structure, twin: Twin, excitation: RandomShaking | Hammer, at: tuple[str, ...],
    seed: int, hidden: bool,
) -> Recording:  # fmt: skip
    """Return one recording; a force that nobody measures acts besides, and is left out."""
    if not hidden:
        return run(_test(structure, excitation, structure.duration_s, at), twin, seed)
    secret, _ = structure.hidden
    at = tuple(name for name in structure.drives if name != secret)[:1]
    channels = (*at, *linear_of(structure).outputs)
    unknown = RandomShaking(HIDDEN_SHARE * structure.rms_n, structure.band_hz)
    measured = _test(structure, excitation, structure.duration_s, at, channels)
    base = run(measured, twin, seed)
    besides = run(_test(structure, unknown, structure.duration_s, (secret,), channels[1:]), twin,
                  seed + 100)  # fmt: skip
    # the structure is linear: what both forces do is the sum of what each does
    data = base.data.copy()
    data[:, 1:] += besides.matrix(base.names[1:])
    return replace(base, data=data)
