"""The frame in ``mujoco.sysid``: what a careful user has to do, as its documentation has it.

- Sensors are stamped with the end of the step they belong to, one step late: a frozen delay of
  minus one step takes that back, and one more control sample lets the last reading exist.
- An accelerometer's y and z are zero throughout, which the normalisation turns into NaN (and then
  the optimiser hands the start back): only x is normalised and returned.
- Controls are held over a step: the actuators integrate the force's slope instead, so that it runs
  straight between samples at 1024 Hz, which stand band-limited between those at 256 Hz.
- Visuals, skins and the clamped ground are deleted; all unknowns are scaled to about one.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from mujoco import sysid

from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.trials import Trial
from twin.mechanisms.damping import Damping
from twin.mechanisms.mass import Mass
from twin.mechanisms.mechanism import StructuralChange
from twin.mechanisms.stiffness import Stiffness
from twin.model import Twin
from twin.second_order import SecondOrderModel
from twin.signals.resampling import resample

Array = np.ndarray
FINE = 4
"""Steps of a simulation in one sampling interval, as in our own free runs."""
WIDE = 3.0
"""Half width of the boxes over the standard deviation of our priors."""


@dataclass(frozen=True)
class Unknown:
    """One of the unknowns: a change, and what it is counted in."""

    change: type[StructuralChange]
    place: str
    unit: float
    tolerance: float

    @property
    def name(self) -> str:
        """Of its parameter."""
        return f"{self.change.name} {self.place}"


def unknowns(model: SecondOrderModel, tolerance: float, damping_tolerance: float) -> list[Unknown]:
    """Return the unknowns of ``base_hypothesis``, each in units of what the model has there.

    A dashpot at the first floor is one in the first storey once more: it is left out.
    """
    base = base_hypothesis(model, tolerance, damping_tolerance)
    out = []
    for change, std in zip(base.base, base.tolerance, strict=True):
        share = damping_tolerance if isinstance(change, Damping) else tolerance
        if not (isinstance(change, Damping) and change.place == "floor1"):
            out.append(Unknown(type(change), change.place, std / share, share))
    return out


def lean_spec(twin: Twin, wanted: Sequence[Unknown], step_s: float) -> mujoco.MjSpec:
    """Return the model as ``mujoco.sysid`` simulates it."""
    spec = mujoco.MjSpec.from_string(twin.mjcf)
    kept = {f"acc_{floor}" for floor in twin.floors}
    for drawn in [*spec.skins, *spec.geoms]:  # masses stand under inertial
        spec.delete(drawn)
    for sensor in [s for s in spec.sensors if s.name not in kept]:
        spec.delete(sensor)
    spec.delete(spec.actuator("force_ground"))
    spec.delete(spec.equality("clamp"))
    spec.delete(spec.joint("ground"))
    for actuator in spec.actuators:
        actuator.dyntype = mujoco.mjtDyn.mjDYN_INTEGRATOR
    for unknown in wanted:
        if unknown.change is Damping:
            Damping(unknown.place, 0.0).apply(spec)
    spec.option.timestep = step_s
    return spec


def modifier(unknown: Unknown) -> Any:
    """Return what writes a change, as a share of what the model has there, into a spec."""

    def write(spec: mujoco.MjSpec, parameter: sysid.Parameter) -> None:
        change = unknown.unit * parameter.value[0]
        if unknown.change is Mass:
            spec.body(unknown.place).mass = unknown.unit + change
        elif unknown.change is Stiffness:
            spec.joint(unknown.place).stiffness = [unknown.unit + change, 0.0, 0.0]
        else:  # beside the model's own, which is that of its modes
            spec.tendon(f"{unknown.place}_damping").damping = [change, 0.0, 0.0]

    return write


def sequences(spec: mujoco.MjSpec, trials: Sequence[Trial], step_s: float) -> sysid.ModelSequences:
    """Return the recordings: the force's slope at the step's rate, accelerations as they are."""
    model = spec.compile()
    states, controls, seen = [], [], []
    for trial in trials:
        force = np.zeros((trial.samples, model.nu))
        for i in range(model.nu):
            if model.actuator(i).name in trial.inputs:
                force[:, i] = trial.u[:, trial.inputs.index(model.actuator(i).name)]
        fine = resample(force, trial.sampling_hz, trial.sampling_hz * FINE)
        slope = np.vstack([np.diff(fine, axis=0) / step_s, np.zeros((2, model.nu))])
        controls.append(sysid.TimeSeries(step_s * np.arange(len(slope)), slope))
        states.append(sysid.create_initial_state(model, np.zeros(2), np.zeros(2), fine[0]))
        xyz = np.zeros((trial.samples, model.nsensordata))
        for name, column in zip(trial.outputs, trial.y.T, strict=True):
            xyz[:, model.sensor(name).adr[0]] = column
        times = np.arange(trial.samples) / trial.sampling_hz
        seen.append(sysid.TimeSeries.from_names(times, xyz, model))
    names = [trial.name for trial in trials]
    return sysid.ModelSequences("frame", spec, names, states, controls, seen)


def calibrated(
    twin: Twin, bench: Bench, tolerance: float, damping_tolerance: float, most: int
) -> tuple[list[StructuralChange], dict[str, Any]]:
    """Return the changes of the model that it finds, and how it got there."""
    step_s = bench.step_s / FINE
    wanted = unknowns(bench.model, tolerance, damping_tolerance)
    params = sysid.ParameterDict()
    for u in wanted:
        reach = WIDE * u.tolerance
        params.add(sysid.Parameter(u.name, 0.0, -reach, reach, modifier=modifier(u)))
    late = sysid.Parameter("late", -step_s, -step_s, -step_s, frozen=True)
    params.add(late)
    transform = sysid.SignalTransform(normalize=False)
    transform.delay("acc_*", late)

    def only_x(*given: Any, **more: Any) -> tuple[Array, sysid.TimeSeries, sysid.TimeSeries]:
        residual, predicted, measured = transform.apply(*given, **more)
        x = slice(0, None, 3)
        seen = measured.data[:, x]
        return (
            sysid.normalize_residual(residual[:, x], seen),
            sysid.TimeSeries(predicted.times, predicted.data[:, x]),
            sysid.TimeSeries(measured.times, seen),
        )

    data = sequences(lean_spec(twin, wanted, step_s), bench.trials, step_s)
    residual = sysid.build_residual_fn(models_sequences=[data], modify_residual=only_x, n_threads=1)
    found, result = sysid.optimize(
        params, residual, verbose=False, max_iters=most, output=io.StringIO()
    )
    objective = result.extras["objective"]
    shares = {u.name: float(found[u.name].value[0]) for u in wanted}
    changes = [u.change(u.place, change=shares[u.name] * u.unit) for u in wanted]
    at_bound = [u.name for u in wanted if abs(shares[u.name]) > 0.999 * WIDE * u.tolerance]
    return changes, {"iterations": len(objective) - 1, "at_bound": at_bound}
