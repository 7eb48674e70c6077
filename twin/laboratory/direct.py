"""What sensors read at once of the inputs, whose corners they have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.channel import AXES, GROUND, bare
from twin.laboratory.analyser import straight_lines
from twin.model.rest import Reduced
from twin.model.sensing import sensor_columns
from twin.model.shaking import drive_name

Array = NDArray[np.float64]

_UNILATERAL = (
    mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS,
    mujoco.mjtDisableBit.mjDSBL_LIMIT,
    mujoco.mjtDisableBit.mjDSBL_CONTACT,
)


def smoothed(
    columns: Mapping[str, Array], model: mujoco.MjModel, inputs: Mapping[str, Array]
) -> dict[str, Array]:
    """Return what sensors read, for a filter that sees inputs as straight lines between samples.

    A motion is smooth between the samples of a simulation; but an accelerometer where a force acts
    reads the force over a mass at once, with its corners, and the filter must see them alike in
    both (``straight_lines``).

    Args:
        columns: sensor -> readings, (samples,).
        model: as it was simulated, with integrators as actuators.
        inputs: actuator or ground's axis -> values, (samples,).
    """
    parts = direct_parts(model, [_drive(name) for name in inputs])
    bent = np.array([straight_lines(values) - values for values in inputs.values()])
    return {
        name: values + parts[name] @ bent if name in parts and np.any(parts[name]) else values
        for name, values in columns.items()
    }


def direct_parts(model: mujoco.MjModel, actuators: Sequence[str]) -> dict[str, Array]:
    """Return what each sensor reads at once of unit values of some actuators, (actuators,).

    At rest, friction and limits left out: a force over the masses that it moves.
    """
    reduced = Reduced(model)
    bare, data = reduced.model, mujoco.MjData(reduced.model)
    bare.opt.disableflags |= sum(int(bit) for bit in _UNILATERAL)
    readings = []
    for name in (None, *actuators):
        mujoco.mj_resetData(bare, data)
        data.qpos[:] = reduced.qpos
        if name is not None:
            index = mujoco.mj_name2id(bare, mujoco.mjtObj.mjOBJ_ACTUATOR, name)
            data.act[bare.actuator_actadr[index]] = 1.0
        mujoco.mj_forward(bare, data)
        readings.append(data.sensordata.copy())
    parts = np.array(readings[1:]) - readings[0]
    return {name: parts[:, column] for name, column in sensor_columns(model).items()}


def _drive(name: str) -> str:
    """Return the actuator that has an input in the simulated model."""
    if not bare(name).startswith(GROUND):
        return name
    axis = name.removeprefix(GROUND).lstrip(".") or AXES[0]
    return drive_name(axis)
