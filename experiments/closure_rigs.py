"""The rigs of the closure test: three structures, and a mechanism of visible size at a place."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from math import pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.formats import write_recording
from twin.instruments import Instrument
from twin.laboratory import Analyser, Experiment, Hammer, RandomShaking, run
from twin.mechanisms import places, vocabulary
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Mechanism, Surroundings
from twin.model import Twin
from twin.model.free_run import free_run
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
def _shaken(model: str) -> Recording:
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


def visible(structure: Structure, name: str) -> Mechanism:
    """Return a mechanism at its place, of a size that recordings show clearly."""
    place, cls = place_of(structure, name), vocabulary()[name]
    around = _around(structure, place)
    k, d = around.stiffness, float(np.sqrt(np.mean(around.drift**2))) or 1.0
    v = float(np.sqrt(np.mean(around.rate**2))) or 1.0
    omega = 2 * pi * around.natural_frequencies[0]
    peak = float(np.abs(around.reading).max())
    level = float(np.sqrt(np.mean(around.reading**2)))
    sizes: dict[str, dict[str, float]] = {
        "stiffness": {"change": 0.12 * k},
        "damping": {"change": 0.04 * k / omega},
        "mass": {"change": 0.2 * around.mass},
        "coulomb_friction": {"force": 0.1 * k * d},
        "cubic_stiffness": {"stiffness": 0.1 * k / d**2},
        "quadratic_stiffness": {"stiffness": 0.1 * k / d},
        "bumper": {"stiffness": 4 * k, "gap": d},
        "clearance": {"stiffness": 0.4 * k, "gap": 0.5 * d, "replaced": 0.4 * k},
        "hysteresis": {"stiffness": 0.3 * k, "yield_force": 0.2 * k * d, "replaced": 0.3 * k},
        "stiffness_drift": {"rate": 0.1 / structure.duration_s},
        "quadratic_drag": {"coefficient": 0.03 * omega * around.mass / v},
        "appendage": {
            "mass": 0.06 * around.mass,
            "frequency": 1.25 * around.natural_frequencies[0],
            "damping_ratio": 0.02,
        },
        "base_compliance": {
            "stiffness": 8 * omega**2 * around.mass_above,
            "damping": 0.2 * omega * around.mass_above,
        },
        "motor_deadband": {"torque": 0.5 * structure.rms_n},
        "motor_delay": {"delay": 0.3 / structure.sampling_hz},
        "sensor_gain": {"gain": 1.1},
        "sensor_delay": {"delay": 0.3 / structure.sampling_hz},
        "sensor_clipping": {"level": 0.5 * peak},
        "sensor_crosstalk": {"first": 0.08, "second": 0.08},
        "sensor_drift": {"rate": 0.2 * level},
        "sensor_hum": {"amplitude": 0.1 * level, "frequency": 50.0, "phase": 1.0},
        "sensor_dropout": {"begin": 5.0, "length": 0.4},
        "sensor_spikes": {"height": 2 * peak, "often": 0.5, "seed": 1.0},
        "sensor_quantisation": {"step": 0.2 * level},
        "sensor_resonance": {"frequency": 0.35 * structure.sampling_hz, "damping_ratio": 0.05},
        "clock": {"rate": 1e-3},
        "sensor_highpass": {"corner": 0.3 * around.natural_frequencies[0]},
    }
    guesses = cls.starts(place, around)
    found = guesses[-1] if guesses else cls(place)
    given = {cls.fields_of.get(field, field): value for field, value in sizes.get(name, {}).items()}
    return replace(found if name not in sizes or not guesses else guesses[0], **given)


def _around(structure: Structure, place: str) -> Surroundings:
    """Return the scales at a place while all shakers act."""
    model, recording = linear_of(structure), _shaken(structure.model)
    n = len(model.coordinates)
    zero = np.zeros((n, n))
    states = replace(
        model, outputs=tuple(f"q{i}" for i in range(n)), Cd=np.eye(n), Cv=zero, Ca=zero,
        Cu=np.zeros((n, len(model.inputs))), rest=np.zeros(n),
    )  # fmt: skip
    q = free_run(states, recording.matrix(structure.drives), structure.sampling_hz)
    total = next(iter(model.base.values())).mass
    mass, row = total, np.zeros(n)
    if place in model.ports:
        row = model.port(place)
        mass = 1 / float(row @ np.linalg.solve(model.M, row))
    if place in model.bodies:
        mass = model.bodies[place].mass
    seen = float(row @ np.linalg.solve(model.K, row))
    reading = recording.column(place) if place in recording.names else np.zeros(1)
    hz = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(model.M, model.K)).real)) / (2 * pi)
    stiffness = 1 / seen if seen > 0 else (2 * pi * hz[0]) ** 2 * total
    return Surroundings(
        stiffness=stiffness, damping=0.02 * stiffness / (2 * pi * hz[0]), mass=mass,
        mass_above=total, height=0.3, drift=q @ row,
        rate=np.gradient(q @ row) * structure.sampling_hz, reading=reading,
        natural_frequencies=tuple(float(f) for f in hz),
        duration_s=structure.duration_s, sampling_hz=structure.sampling_hz,
    )  # fmt: skip


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
