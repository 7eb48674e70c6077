"""Mechanisms of visible size at a place of a closure rig."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np

from experiments.closure_rigs import Structure, linear_of, place_of, shaken
from twin.mechanisms import vocabulary
from twin.mechanisms.mechanism import Mechanism, Surroundings
from twin.mechanisms.p_delta import PDelta
from twin.model.free_run import free_run

WEIGHT = 0.03
"""Share of its stiffness that a weight must take at a port to be seen: three times a drawing's
tolerance."""


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
        "quadratic_stiffness": {"stiffness": 0.05 * k / d},  # runs away at -20 d,
        "bumper": {"stiffness": 4 * k, "gap": d},
        "clearance": {"stiffness": 0.4 * k, "gap": 0.5 * d, "replaced": 0.4 * k},
        "hysteresis": {"stiffness": 0.3 * k, "yield_force": 0.2 * k * d, "replaced": 0.3 * k},
        "microslip": {"stiffness": 0.3 * k, "softening": 1.0, "replaced": 0.3 * k, "reach": d},
        "stiffness_drift": {"rate": 0.1 / structure.duration_s},
        "quadratic_drag": {"coefficient": 0.03 * omega * around.mass / v},
        "appendage": {
            "mass": 0.06 * around.mass,
            "frequency": 1.25 * around.natural_frequencies[structure.tuned],
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
        "p_delta": {"factor": 1.0},
        "sensor_highpass": {"corner": 0.3 * around.natural_frequencies[0]},
    }
    guesses = cls.starts(place, around)
    found = guesses[-1] if guesses else cls(place)
    given = {cls.fields_of.get(field, field): value for field, value in sizes.get(name, {}).items()}
    return replace(found if name not in sizes or not guesses else guesses[0], **given)


def shows(structure: Structure, name: str) -> bool:
    """Return whether a mechanism can be seen at its place: a weight only where it is heavy enough.

    One that takes less of the stiffness than a drawing may err is a stiffness within its tolerance,
    and no more than its full weight can act.
    """
    if not issubclass(vocabulary()[name], PDelta):
        return True
    mechanism, model = visible(structure, name), linear_of(structure)
    assert isinstance(mechanism, PDelta)
    bent = np.linalg.solve(model.K, model.port(mechanism.place))
    softer = float(bent @ mechanism.edit(model).K @ bent) / float(bent @ model.K @ bent)
    return 1 - softer > WEIGHT


def _around(structure: Structure, place: str) -> Surroundings:
    """Return the scales at a place while all shakers act."""
    model, recording = linear_of(structure), shaken(structure.model)
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
