"""What can be concealed in a structure, and how it enters its equations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .. import laws
from ..mechanisms import STOREY, Mechanism
from ..plans import FADE_S, FINE_HZ, band_limited
from .plan import Kit, Trial, signals
from .stepping import simulate, system_of
from .structure import Array, Structure

AT_DRIFT = STOREY
AT_POINT = ("quadratic_drag", "appendage", "unmeasured_force")
AT_CHANNEL = ("sensor_gain", "sensor_delay", "sensor_polarity")
Law = tuple[int, list[float], Array]


def changed(structure: Structure, effects: Sequence[Mechanism]) -> Structure:
    """Return the structure with those effects that are linear built in."""
    for m in effects:
        if m.name == "stiffness":
            structure = structure.stiffer(m.location, m["change"])
        elif m.name == "damping":
            structure = structure.stiffer(m.location, 0.0, m["change"])
        elif m.name == "mass":
            structure = structure.heavier(structure.bodies[m.location].points, m["change"])
        elif m.name == "appendage":
            omega = 2 * np.pi * m["frequency"]
            dashpot = 2 * m["damping_ratio"] * m["mass"] * omega
            spring = m["mass"] * omega**2
            structure = structure.hanging(m.location, m["mass"], dashpot, spring)
        elif m.name == "base_compliance":
            axis = m.location.partition(".")[2]
            structure = structure.on_soft_ground(axis, m["damping"], m["stiffness"])
    return structure


def law_of(structure: Structure, m: Mechanism) -> Law | None:
    """Return code, parameters and row of an effect's law; None where it has none."""
    if m.name == "quadratic_drag":
        return laws.DRAG, [m["coefficient"]], structure.row(m.location)
    if m.name not in AT_DRIFT or m.name in ("stiffness", "damping"):
        return None
    row = structure.row(m.location)
    if m.name == "coulomb_friction":
        return laws.COULOMB, [m["force"]], row
    if m.name == "cubic_stiffness":
        return laws.POLYNOMIAL, [0.0, m["stiffness"]], row
    if m.name == "quadratic_stiffness":
        return laws.POLYNOMIAL, [m["stiffness"], 0.0], row
    if m.name == "bumper":
        return laws.BUMPER, [m["gap"], m["stiffness"]], row
    if m.name == "clearance":
        return laws.CLEARANCE, [m["gap"], m["stiffness"]], row
    if m.name == "stiffness_drift":
        return laws.DRIFTING, [structure.scales[m.location], m["rate"]], row
    slope = [m["stiffness"], m["yield_force"]]
    if m.form == "jenkins":
        return laws.JENKINS, slope, row
    return laws.BOUC_WEN, [*slope, 2.0 if m.form == "bouc_wen_2" else 1.0], row


def moved(
    structure: Structure, effects: Sequence[Mechanism], trial: Trial, kit: Kit
) -> tuple[dict[str, Array], dict[str, Array], Array]:
    """Return inputs, true channels and coordinates on the integrator's grid.

    Args:
        structure: as built.
        effects: what is concealed.
        trial: the recording.
        kit: of its table.
    """
    built = changed(structure, [m for m in effects if not m.in_sensor])
    found = [law_of(built, m) for m in effects if not m.in_sensor]
    driven = signals(trial, kit)
    pushes, columns = [], []
    ground: dict[str, Array] = {}
    inputs: dict[str, Array] = {}
    plant = built
    for name, column in zip(trial.inputs, driven.T, strict=True):
        if trial.kind == "ground":
            pushes.append(-built.shaken[name].coupling)
            ground[name] = column
            inputs[f"acc_ground.{name}"] = column
        else:
            pushes.append(built.drives[name].row)
            inputs[name] = column
        columns.append(column)
    if kit.loop is not None:
        spring, dashpot = kit.loop
        row = pushes[0]
        plant = built.held(row, spring, dashpot)
        path = columns[0]
        columns[0] = spring * path + dashpot * np.gradient(path, 1 / FINE_HZ)
    for m in effects:
        if m.name == "unmeasured_force":
            pushes.append(built.row(m.location))
            columns.append(_unknown(m, trial))
    system = system_of(plant, pushes, [law for law in found if law is not None])
    states, accelerations = simulate(system, np.column_stack(columns), 1 / FINE_HZ, kit.substeps)
    q, v = states[:, : built.size], states[:, built.size : 2 * built.size]
    if kit.loop is not None:
        row = pushes[0]
        inputs[trial.inputs[0]] = columns[0] - kit.loop[0] * q @ row - kit.loop[1] * v @ row
    seen = {
        name: accelerations @ s.acc + q @ s.disp
        + sum(s.ground.get(axis, 0.0) * a for axis, a in ground.items())
        for name, s in built.sensors.items()
    }  # fmt: skip
    return inputs, seen, np.hstack([q, v])


def _unknown(m: Mechanism, trial: Trial) -> Array:
    """Return the unmeasured force of a recording [N]."""
    rng = np.random.default_rng([trial.seed, 5, *m.location.encode()])
    time = np.arange(trial.fine_samples) / FINE_HZ
    if m.form == "sine":
        phase = rng.uniform(0, 2 * np.pi)
        return np.asarray(m["rms"] * np.sqrt(2) * np.sin(2 * np.pi * m["frequency"] * time + phase))
    low, high = 0.8 * m["frequency"], 1.2 * m["frequency"]
    noise = band_limited(rng, len(time), FINE_HZ, low, high)
    return np.asarray(m["rms"] * noise * np.minimum(time / FADE_S, 1.0))
