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

from twin.arrays import filled
from twin.diagnosis.exported import dashpots
from twin.diagnosis.problem import Measured, Problem
from twin.mechanisms.damping import Damping
from twin.mechanisms.mass import Mass
from twin.mechanisms.stiffness import Stiffness
from twin.model import Twin
from twin.signals.resampling import resample

Array = np.ndarray
Change = Stiffness | Mass | Damping
FINE = 4
"""Steps of a simulation in one sampling interval, as in our own free runs."""
WIDE = 3.0
"""Half width of the boxes over the standard deviation of our priors."""


@dataclass(frozen=True)
class Unknown:
    """A change of the model that is looked for.

    Attributes:
        change: what kind of change.
        place: port or body.
        unit: what the model has there [N/m, kg, N s/m]: a share of it is the parameter.
        tolerance: prior deviation of that share.
    """

    change: type[Stiffness] | type[Mass] | type[Damping]
    place: str
    unit: float
    tolerance: float

    @property
    def name(self) -> str:
        """Of its parameter."""
        return f"{self.change.name} {self.place}"

    def at(self, share: float) -> Change:
        """Return the change that is a share of what the model has there."""
        return self.change(self.place, change=share * self.unit)


def unknowns(problem: Problem) -> list[Unknown]:
    """Return the unknowns of our calibration, as a user writes them into an MJCF.

    Ours has the dampings of the modes; here there are as many dashpots as hold any damping matrix.
    """
    model = problem.model
    compliance = np.linalg.inv(model.R)

    def seen(place: str) -> float:
        row = model.port(place)
        return float(1 / (row @ compliance @ row))

    places = [dashpot.place for dashpot in dashpots(model, model.R)]
    loose = problem.damping_tolerance
    return [
        *(Unknown(Stiffness, name, k, problem.tolerance) for name, _, k in problem.stiffnesses),
        *(Unknown(Mass, name, body.mass, problem.tolerance) for name, body in problem.masses),
        *(Unknown(Damping, place, seen(place), loose) for place in places),
    ]


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


def sequences(
    spec: mujoco.MjSpec, problem: Problem, recordings: Sequence[Measured], step_s: float
) -> sysid.ModelSequences:
    """Return the recordings: the force's slope at the step's rate, accelerations as they are.

    A sample that is left out would make the residual NaN: it is interpolated.
    """
    model = spec.compile()
    inputs, rate = problem.model.inputs, problem.sampling_hz
    states, controls, seen = [], [], []
    for recording in recordings:
        samples = len(recording.y)
        force = np.zeros((samples, model.nu))
        for i in range(model.nu):
            if model.actuator(i).name in inputs:
                force[:, i] = recording.u[:, inputs.index(model.actuator(i).name)]
        fine = resample(force, rate, rate * FINE)
        slope = np.vstack([np.diff(fine, axis=0) / step_s, np.zeros((2, model.nu))])
        controls.append(sysid.TimeSeries(step_s * np.arange(len(slope)), slope))
        states.append(sysid.create_initial_state(model, np.zeros(2), np.zeros(2), fine[0]))
        xyz = np.zeros((samples, model.nsensordata))
        for name, column in zip(problem.model.outputs, filled(recording.y).T, strict=True):
            xyz[:, model.sensor(name).adr[0]] = column
        times = np.arange(samples) / rate
        seen.append(sysid.TimeSeries.from_names(times, xyz, model))
    names = [recording.name for recording in recordings]
    return sysid.ModelSequences("frame", spec, names, states, controls, seen)


def calibrated(
    twin: Twin, problem: Problem, recordings: Sequence[Measured], most: int
) -> tuple[list[Change], dict[str, Any]]:
    """Return the changes of the model that it finds, and how it got there.

    Args:
        twin: the model.
        problem: what is known of it and how well.
        recordings: those of the problem that are fitted, or parts of them.
        most: iterations.
    """
    step_s = problem.step_s / FINE
    wanted = unknowns(problem)
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

    data = sequences(lean_spec(twin, wanted, step_s), problem, recordings, step_s)
    residual = sysid.build_residual_fn(models_sequences=[data], modify_residual=only_x, n_threads=1)
    found, result = sysid.optimize(
        params, residual, verbose=False, max_iters=most, output=io.StringIO()
    )
    objective = result.extras["objective"]
    shares = {u.name: float(found[u.name].value[0]) for u in wanted}
    at_bound = [u.name for u in wanted if abs(shares[u.name]) > 0.999 * WIDE * u.tolerance]
    changes = [u.at(shares[u.name]) for u in wanted]
    return changes, {"iterations": len(objective) - 1, "at_bound": at_bound}
