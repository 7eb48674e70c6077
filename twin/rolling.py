"""Roll a compiled model out in MuJoCo, no Python between the steps."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import mujoco
import numpy as np
from mujoco import rollout
from numpy.typing import NDArray

from twin.contract import names_in
from twin.errors import ModelError, available
from twin.model.rest import Reduced, settle
from twin.model.sensing import channel_columns, sensor_columns

Array = NDArray[np.float64]

CHUNK = 8192
"""Steps between two reports of progress; bounds the memory for states, too."""

_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS


def input_table(
    model: mujoco.MjModel, inputs: Mapping[str, Array], samples: int, source: str
) -> Array:
    """Return the inputs as columns in the order of the actuators, (samples, nu).

    Raises:
        ModelError: an unknown actuator, or values of a wrong length or not finite.
    """
    names = names_in(model)["actuator"]
    table = np.zeros((samples, model.nu))
    for name, values in inputs.items():
        if name not in names:
            raise ModelError(f"{source}: no actuator '{name}'; it has {available(names)}")
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, name)
        if model.actuator_dyntype[index] != mujoco.mjtDyn.mjDYN_INTEGRATOR:
            raise ModelError(f"{source}: actuator '{name}' has dynamics of its own")
        column = np.asarray(values, float)
        if column.shape != (samples,):
            raise ModelError(f"{source}: '{name}' has shape {column.shape}, expected ({samples},)")
        if not np.all(np.isfinite(column)):
            bad = int(np.flatnonzero(~np.isfinite(column))[0])
            raise ModelError(f"{source}: sample {bad + 1} of '{name}' is not finite")
        table[:, index] = column
    return table


def substeps(model: mujoco.MjModel, rate_hz: float) -> int:
    """Return the steps a sample needs so that none is longer than the model's own step."""
    return max(1, math.ceil(1 / (rate_hz * model.opt.timestep) - 1e-9))


def roll(
    model: mujoco.MjModel,
    table: Array,
    rate_hz: float,
    source: str,
    progress: Callable[[float], None] | None = None,
) -> tuple[Array, dict[str, Array], dict[str, Array]]:
    """Simulate from rest with inputs that are linear between samples.

    Args:
        model: compiled with integrators as actuators; its step is set here.
        table: input values, (samples, nu).
        rate_hz: samples per second.
        source: the model's name, for messages.
        progress: called with the fraction that is done.

    Returns:
        Joint positions (samples, nq), and what sensors read, by the names of their channels
        (``sensing.channel_columns``) and of all others that a vector sensor's axes have.

    Raises:
        ModelError: the model's timestep is not positive, or the motion diverges.
    """
    if not model.opt.timestep > 0:
        raise ModelError(f"{source}: the timestep must be positive, not {model.opt.timestep}")
    count = substeps(model, rate_hz)
    model.opt.timestep = 1 / (rate_hz * count)
    data = mujoco.MjData(model)
    reduced = Reduced(model)
    settle(reduced)
    data.qpos[:] = reduced.qpos
    integrators = np.flatnonzero(model.actuator_dyntype == mujoco.mjtDyn.mjDYN_INTEGRATOR)
    data.act[model.actuator_actadr[integrators]] = table[0, integrators]
    state = np.zeros(mujoco.mj_stateSize(model, _STATE))
    mujoco.mj_getState(model, data, state, _STATE)

    samples = len(table)
    slopes = np.diff(table, axis=0, append=table[-1:]) * rate_hz
    channels, sensors = channel_columns(reduced), sensor_columns(reduced.model)
    measured = np.empty((samples, len(sensors)))
    qpos = np.empty((samples, model.nq))
    chunk = max(1, CHUNK // count)
    mujoco.set_mju_user_warning(lambda message: None)  # else a log file in the user's folder
    try:
        for start in range(0, samples, chunk):
            stop = min(start + chunk, samples)
            control = np.repeat(slopes[start:stop], count, axis=0)
            states, readings = rollout.rollout(
                model, data, state[None], control[None], skip_checks=False
            )
            # Readings after a step belong to the state before it; so do these positions.
            before = np.vstack([state, states[0, :-1]])[::count]
            qpos[start:stop] = before[:, 1 : 1 + model.nq]
            measured[start:stop] = readings[0, ::count, list(sensors.values())].T
            state = states[0, -1]
            _check(model, data, source, measured[start:stop], (start, stop), rate_hz)
            if progress is not None:
                progress(stop / samples)
    finally:
        mujoco.set_mju_user_warning(None)
    every = {name: measured[:, index] for index, name in enumerate(sensors)}
    others = {name: values for name, values in every.items() if name not in channels}
    return qpos, {name: every[name] for name in channels}, others


def _check(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    source: str,
    measured: Array,
    window: tuple[int, int],
    rate_hz: float,
) -> None:
    kinds = mujoco.mjtWarning
    bad = (kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC)
    warned = any(data.warning[int(kind)].number for kind in bad)
    if warned or not np.all(np.isfinite(measured)):
        start, stop = (round(n / rate_hz, 3) for n in window)
        raise ModelError(
            f"{source}: the motion diverges between {start} s and {stop} s; check masses, "
            f"stiffness and damping, or lower the timestep ({model.opt.timestep:.3g} s used)"
        )
