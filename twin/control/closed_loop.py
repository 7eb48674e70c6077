"""The closed loop inside MuJoCo: physics at 1 kHz or above, the controller at its own rate."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.contract import channel_sensors
from twin.control.absorber import SHAKE_TABLE
from twin.control.controller import Controller
from twin.control.lqg import check_rate
from twin.control.outcome import Outcome
from twin.control.plant import ANGLE, TORQUE, Plant
from twin.control.sampling import Converters
from twin.errors import ControlError, available
from twin.instruments import Instrument
from twin.laboratory.excitation import Excitation, TimeBase
from twin.laboratory.experiment import stream
from twin.linearise import equilibrium
from twin.model.shaking import drive_name

Array = NDArray[np.float64]


class Steps(Protocol):
    """A running controller: the one of ``Controller.start``, or exported code in its place."""

    limited: int

    def switch(self, on: bool) -> None:
        """Switch the torque on or off."""

    def step(self, y: Array, f: float) -> float:
        """Return the torque [N m] for the measurements and the known input of this instant."""

    def estimate(self) -> Array:
        """Return what is estimated for this instant."""


@dataclass(frozen=True)
class Schedule:
    """How long a run lasts and when the controller is switched on, Figs. 9-10.

    Attributes:
        duration_s: [s].
        switch_s: the first instant of control [s]; the end of the run for none.
    """

    duration_s: float = 64.0
    switch_s: float = 32.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.duration_s) and 0 <= self.switch_s <= self.duration_s):
            raise ControlError(
                f"control must begin within the run: {self.switch_s:g} s of {self.duration_s:g} s"
            )


def run(
    plant: Plant,
    controller: Controller,
    excitation: Excitation,
    schedule: Schedule | None = None,
    seed: int = 0,
    instruments: Mapping[str, Instrument] | None = None,
    steps: Steps | None = None,
    progress: Callable[[float], None] | None = None,
) -> Outcome:
    """Run the plant with the controller in the loop.

    At each of its instants the controller reads what the instruments give; its torque acts from
    ``plant.delay`` samples later on, held in between. The excitation runs straight between the
    physics steps.

    Args:
        plant: the truth.
        controller: off until ``schedule.switch_s``; its estimator runs from the start.
        excitation: a force, or the ground's acceleration if the plant is on a shake table.
        schedule: 64 s, control from 32 s on, by default.
        seed: of excitation and instruments.
        instruments: by channel or kind, others as in ``sampling.INSTRUMENTS``.
        steps: runs in the place of ``controller.start()``: exported code, for one.
        progress: told the share that is done.

    Raises:
        ControlError: the controller does not fit the plant, or the plant diverges.
    """
    schedule = schedule or Schedule()
    check_rate(controller.rate_hz, 0.0)
    if excitation.moves_the_ground != (plant.known_input == SHAKE_TABLE):
        raise ControlError(
            f"a {excitation.kind} excitation does not act as '{plant.known_input}' on the plant"
        )
    model = plant.compile()
    inner = max(1, math.ceil(controller.dt / model.opt.timestep - 1e-9))
    model.opt.timestep = controller.dt / inner
    samples = round(schedule.duration_s * controller.rate_hz)
    switch = round(schedule.switch_s * controller.rate_hz)
    base = TimeBase(controller.rate_hz * inner, inner, 0, samples * inner + 1, samples + 1)
    force = excitation.history(base, stream(seed, 0, f"excitation {excitation.kind}"))
    channels = (*controller.measurements, controller.known_input)
    converters = Converters(channels, instruments or {}, samples, seed)
    steps = steps or controller.start()
    sensors = _sensors(model, plant, controller)
    trace = _roll(model, plant, force, inner, steps, converters, sensors, switch, progress)
    columns = channel_sensors(model)
    floors = plant.twin.floors
    ground = trace.readings[:, columns["disp_ground"]] if "disp_ground" in columns else 0.0
    displacement = np.column_stack(
        [trace.readings[:, columns[f"disp_{floor}"]] - ground for floor in floors]
    )
    return Outcome(
        rate_hz=controller.rate_hz,
        physics_hz=base.rate_hz,
        switch_s=switch / controller.rate_hz,
        floors=floors,
        displacement=displacement - displacement[0],
        angle=trace.readings[:, columns[ANGLE]],
        known_input=controller.known_input,
        excitation=force[:-1],
        channels=channels,
        measured=trace.measured,
        torque=trace.torque,
        estimates=controller.estimates,
        estimated=trace.estimated,
        qpos=trace.qpos,
        limited=max(trace.limited, steps.limited),
        clipped={n: int(c) for n, c in zip(channels, converters.clipped, strict=True) if c},
    )


def _sensors(model: mujoco.MjModel, plant: Plant, controller: Controller) -> NDArray[np.intp]:
    """Return where in MuJoCo's readings the controller's measurements are."""
    there = channel_sensors(model)
    wanted = [*controller.measurements]
    if controller.known_input != plant.known_input:
        raise ControlError(
            f"the controller reads '{controller.known_input}', the plant is excited by "
            f"'{plant.known_input}'"
        )
    missing = [name for name in wanted if name not in there]
    if missing:
        raise ControlError(
            f"{plant.twin.source}: no sensor {', '.join(missing)} for the controller; it has "
            f"{available(there)}"
        )
    return np.array([there[name] for name in wanted])


@dataclass
class _Trace:
    """What a run writes down."""

    readings: Array
    qpos: Array
    torque: Array
    measured: Array
    estimated: Array
    limited: int = 0


def _roll(
    model: mujoco.MjModel,
    plant: Plant,
    force: Array,
    inner: int,
    steps: Steps,
    converters: Converters,
    sensors: NDArray[np.intp],
    switch: int,
    progress: Callable[[float], None] | None,
) -> _Trace:
    """Step physics and controller through the whole run."""
    samples = (len(force) - 1) // inner
    data = mujoco.MjData(model)
    data.qpos[:] = equilibrium(model)
    drive = drive_name("x") if plant.known_input == SHAKE_TABLE else plant.known_input
    driven, motor = model.actuator(drive).id, model.actuator(TORQUE).id
    address = model.actuator_actadr
    data.act[address[driven]] = force[0]
    slope = np.diff(force) / model.opt.timestep
    trace = _Trace(
        np.empty((samples * inner, model.nsensordata)),
        np.empty((samples, model.nq)),
        np.zeros(samples),
        np.empty((samples, len(sensors) + 1)),
        np.empty((samples, len(steps.estimate()))),
    )
    readings, sensordata, act, ctrl = trace.readings, data.sensordata, data.act, data.ctrl
    limit, late = plant.torque_limit, deque([0.0] * plant.delay)
    true = np.empty(len(sensors) + 1)
    report = max(1, samples // 100)
    mujoco.set_mju_user_warning(lambda message: None)  # else a log file in the user's folder
    try:
        for k in range(samples):
            if k == switch:
                steps.switch(True)
            mujoco.mj_forward(model, data)
            true[:-1] = sensordata[sensors]
            true[-1] = force[k * inner]
            measured = converters.read(k, true)
            late.append(steps.step(measured[:-1], measured[-1]))
            torque = late.popleft()
            if abs(torque) > limit:
                torque = math.copysign(limit, torque)
                trace.limited += 1
            act[address[motor]] = torque
            trace.qpos[k], trace.torque[k], trace.measured[k] = data.qpos, torque, measured
            trace.estimated[k] = steps.estimate()
            for j in range(k * inner, (k + 1) * inner):
                ctrl[driven] = slope[j]
                mujoco.mj_step(model, data)
                readings[j] = sensordata
            if progress is not None and k % report == 0:
                progress(k / samples)
            if not math.isfinite(true[0]):
                break
    finally:
        mujoco.set_mju_user_warning(None)
    if not np.all(np.isfinite(readings[: (k + 1) * inner])):
        raise ControlError(
            f"{plant.twin.source}: the motion diverges before {k / samples:.3g} of the run"
        )
    return trace
