"""What can be concealed, where, and how it enters the rig's equations."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from . import laws, near_laws
from .rig import Array, Rig, System, enlarged, linear_system

STOREY = (
    "stiffness", "damping", "coulomb_friction", "cubic_stiffness", "quadratic_stiffness", "bumper",
    "clearance", "hysteresis", "stiffness_drift",
)  # fmt: skip
FLOOR = ("mass", "quadratic_drag", "appendage", "unmeasured_force")
GROUND = ("base_compliance", "unmeasured_force")
SENSOR = ("sensor_gain", "sensor_delay", "sensor_polarity", "sensor_clipping", "sensor_highpass")

MAIN = {
    "stiffness": "change", "damping": "change", "mass": "change", "coulomb_friction": "force",
    "cubic_stiffness": "stiffness", "quadratic_stiffness": "stiffness", "bumper": "gap",
    "clearance": "gap", "hysteresis": "yield_force", "stiffness_drift": "rate",
    "quadratic_drag": "coefficient", "appendage": "mass", "base_compliance": "stiffness",
    "unmeasured_force": "rms", "sensor_gain": "gain", "sensor_delay": "delay",
    "sensor_clipping": "level", "sensor_highpass": "corner",
}  # fmt: skip
"""The parameter that stands for the strength; a swap and a polarity have none."""

_GAP = ("gap", "stiffness", "opening", "period", "phase")
UNNAMED = {
    "tanh_spring": (laws.TANH, ("stiffness", "width")),
    "sine_spring": (laws.SINE, ("stiffness", "width")),
    "exponential_spring": (laws.EXPONENTIAL, ("stiffness", "width")),
    "magnet": (laws.MAGNET, ("force", "gap", "exponent")),
    "breathing_gap": (laws.BREATHING_GAP, _GAP),
    "moving_stop": (laws.MOVING_STOP, _GAP),
    "cross_axis": (laws.CROSS_AXIS, ("coupling",)),
}
"""Effects outside the vocabulary: law, and the names of its parameters in their order."""

NEAR = {
    "stribeck_friction": (near_laws.STRIBECK, ("breakaway", "force", "velocity")),
    "smooth_friction": (near_laws.SMOOTH, ("force", "velocity")),
    "dahl_friction": (near_laws.DAHL, ("stiffness", "force")),
    "lugre_friction": (
        near_laws.LUGRE, ("stiffness", "damping", "force", "breakaway", "velocity"),
    ),
    "damped_bumper": (near_laws.HUNT_CROSSLEY, ("gap", "stiffness", "damping")),
    "hertz_bumper": (near_laws.HERTZ, ("gap", "stiffness")),
    "power_spring": (near_laws.POWER, ("stiffness", "exponent")),
    "iwan_slip": (near_laws.IWAN, ("stiffness", "yield_force", "exponent")),
}  # fmt: skip
"""The same, of effects whose law is nearly that of a name of the vocabulary."""

NEAREST = {
    "stribeck_friction": "coulomb_friction", "smooth_friction": "coulomb_friction",
    "dahl_friction": "coulomb_friction", "lugre_friction": "coulomb_friction",
    "damped_bumper": "bumper", "hertz_bumper": "bumper", "power_spring": "cubic_stiffness",
    "iwan_slip": "hysteresis",
}  # fmt: skip
"""The name of the vocabulary that is nearest."""

VERDICT = {
    "none": "consistent", "stiffness": "parameter", "damping": "parameter", "mass": "parameter",
    "sensor_gain": "measurement", "sensor_delay": "measurement", "sensor_polarity": "measurement",
    "sensor_clipping": "measurement", "sensor_highpass": "measurement",
    "sensor_swap": "measurement",
}  # fmt: skip
"""The verdict that belongs to a mechanism; missing physics where it is not listed."""


@dataclass(frozen=True)
class Mechanism:
    """One effect at one place.

    Attributes:
        name: of the vocabulary; "none" for nothing.
        location: storey, floor, ground or channel.
        parameters: SI units.
        form: which of several laws of that name, or of several waveforms.
    """

    name: str = "none"
    location: str = ""
    parameters: tuple[tuple[str, float], ...] = ()
    form: str = ""

    def __getitem__(self, parameter: str) -> float:
        return dict(self.parameters)[parameter]

    @property
    def index(self) -> int:
        """Storey or floor, from 0; -1 for the ground."""
        return int(self.location[-1]) - 1 if self.location[-1:].isdigit() else -1

    @property
    def in_sensor(self) -> bool:
        """True for a fault of the measurement."""
        return self.name.startswith("sensor_")

    def as_json(self) -> dict[str, Any]:
        """Return plain types."""
        return {**asdict(self), "parameters": dict(self.parameters)}

    @classmethod
    def from_json(cls, entry: dict[str, Any]) -> Mechanism:
        """Undo ``as_json``."""
        parameters = tuple(entry["parameters"].items())
        return cls(entry["name"], entry["location"], parameters, entry["form"])


def places(storeys: int) -> tuple[tuple[str, str], ...]:
    """Return every (mechanism, location) that a frame of that many storeys has."""
    numbers = range(1, storeys + 1)
    accelerometers = [f"acc_floor{i}" for i in numbers]
    found = [(name, f"storey{i}") for name in STOREY for i in numbers]
    found += [(name, f"floor{i}") for name in FLOOR for i in numbers]
    found += [(name, "ground") for name in GROUND]
    found += [(name, channel) for name in SENSOR for channel in accelerometers]
    found += [("sensor_gain", f"force_floor{i}") for i in numbers]
    found += [
        ("sensor_swap", f"{a}+{b}") for k, a in enumerate(accelerometers)
        for b in accelerometers[k + 1 :]
    ]  # fmt: skip
    return tuple(found)


def build(rig: Rig, *effects: Mechanism) -> System:
    """Return the rig with the effects built in; a sensor's fault leaves the motion alone."""
    system = linear_system(rig)
    for m in effects:
        if m.name in ("stiffness", "damping"):
            row = rig.drifts[m.index]
            added = m["change"] * np.outer(row, row)
            system = system._replace(**{m.name: getattr(system, m.name) + added})
        elif m.name == "mass":
            added = m["change"] * (np.arange(rig.storeys) == m.index)
            system = system._replace(mass=system.mass + added)
    ground = -1
    for m in effects:
        if m.name == "base_compliance":
            system, ground = _on_soft_ground(rig, system, m), rig.storeys
    for m in effects:
        if m.name == "appendage":
            system = _with_appendage(system, m)
    for m in effects:
        code, parameters = law_of(rig, m)
        if code == laws.LINEAR:
            continue
        if code == laws.CROSS_AXIS:
            system = _with_cross_axis(system, m)
        below = m.index - 1 if m.index > 0 else ground
        system = system.with_law(code, parameters, m.index, -1 if code == laws.DRAG else below)
    return system


def law_of(rig: Rig, mechanism: Mechanism) -> tuple[int, list[float]]:
    """Return the code and the parameters of the law, LINEAR where there is none."""
    m = mechanism
    if m.name == "coulomb_friction":
        return laws.COULOMB, [m["force"]]
    if m.name == "cubic_stiffness":
        return laws.POLYNOMIAL, [0.0, m["stiffness"]]
    if m.name == "quadratic_stiffness":
        return laws.POLYNOMIAL, [m["stiffness"], 0.0]
    if m.name == "bumper":
        return laws.BUMPER, [m["gap"], m["stiffness"]]
    if m.name == "clearance":
        return laws.CLEARANCE, [m["gap"], m["stiffness"]]
    if m.name == "hysteresis":
        slope = [m["stiffness"], m["yield_force"]]
        if m.form == "jenkins":
            return laws.JENKINS, slope
        return laws.BOUC_WEN, [*slope, 2.0 if m.form == "bouc_wen_2" else 1.0]
    if m.name == "stiffness_drift":
        return laws.DRIFTING, [rig.stiffnesses[m.index], m["rate"]]
    if m.name == "quadratic_drag":
        return laws.DRAG, [m["coefficient"]]
    if m.name in UNNAMED or m.name in NEAR:
        code, names = {**UNNAMED, **NEAR}[m.name]
        return code, [m[name] for name in names]
    return laws.LINEAR, []


def _with_appendage(system: System, m: Mechanism) -> System:
    """Return the system with a small oscillator on a floor."""
    mass, omega = m["mass"], 2 * np.pi * m["frequency"]
    floor = np.eye(len(system.mass) + 1)[m.index]
    column = np.eye(len(system.mass) + 1)[-1] - floor
    spring, dashpot = mass * omega**2, 2 * m["damping_ratio"] * mass * omega
    larger = enlarged(system, mass, np.array([spring * column, dashpot * column, 0 * column]))
    return larger._replace(
        stiffness=larger.stiffness + spring * np.outer(floor, floor),
        damping=larger.damping + dashpot * np.outer(floor, floor),
    )


def _with_cross_axis(system: System, m: Mechanism) -> System:
    """Return the system with a mode of another axis, which the law couples to the drift."""
    omega = 2 * np.pi * m["frequency"]
    spring, dashpot = m["mass"] * omega**2, 2 * m["damping_ratio"] * m["mass"] * omega
    last = np.eye(len(system.mass) + 1)[-1]
    larger = enlarged(system, m["mass"], np.array([spring * last, dashpot * last, 0 * last]))
    return larger._replace(aside=len(system.mass))


def _on_soft_ground(rig: Rig, system: System, m: Mechanism) -> System:
    """Return the rig on a ground that moves; damping stays that of the drifts."""
    n = rig.storeys
    ones = np.ones(n)
    columns = np.zeros((3, n + 1))
    for row, matrix, own in ((0, system.stiffness, "stiffness"), (1, system.damping, "damping")):
        columns[row, :n] = -matrix @ ones
        columns[row, n] = ones @ matrix @ ones + m[own]
    return enlarged(system, rig.ground_mass, columns)


def unmeasured(rig: Rig, m: Mechanism, waveform: Array) -> Array:
    """Return the unmeasured forces on the floors [N], (samples, floors).

    A ground acceleration acts as -m a on every floor; what accelerometers on the floors see of
    it besides, is ``waveform`` itself and is added by the caller.
    """
    share = -np.array(rig.masses) if m.location == "ground" else np.eye(rig.storeys)[m.index]
    return np.outer(waveform, share)
