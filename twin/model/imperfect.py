"""Sensors and motors of a user's model that are not ideal: limits and delays written in it."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from twin.model.nonlinear import NonlinearElement
from twin.model.rest import Reduced
from twin.model.sensing import channel_columns

_OBJ = mujoco.mjtObj


def imperfect_instruments(reduced: Reduced, model: mujoco.MjModel) -> Iterator[NonlinearElement]:
    """Yield what limits or delays a channel, one for each channel.

    Args:
        reduced: the model at its rest.
        model: as it was compiled, its sensors' limits and delays in place.
    """
    columns = channel_columns(reduced)
    for index in range(model.nsensor):
        name = mujoco.mj_id2name(model, _OBJ.mjOBJ_SENSOR, index)
        first, size = int(model.sensor_adr[index]), int(model.sensor_dim[index])
        cutoff, delay = float(model.sensor_cutoff[index]), float(model.sensor_delay[index])
        for channel in (c for c, at in columns.items() if first <= at < first + size):
            what = f"sensor {name}"
            if cutoff > 0:
                words = f"{channel} reads no more than {cutoff:.4g}"
                values = {"level": cutoff}
                yield NonlinearElement(
                    what, channel, "sensor_clipping", values, words, None, cutoff
                )
            if delay > 0:
                words = f"{channel} is {delay:.4g} s late"
                yield NonlinearElement(what, channel, "sensor_delay", {"delay": delay}, words)
    for index in range(model.nu):
        name = mujoco.mj_id2name(model, _OBJ.mjOBJ_ACTUATOR, index)
        delay = float(model.actuator_delay[index])
        if name and delay > 0:
            words = f"acts {delay:.4g} s late"
            yield NonlinearElement(
                *(f"actuator {name}", name, "motor_delay", {"delay": delay}, words)
            )
        gain = abs(float(model.actuator_gainprm[index, 0])) or 1.0
        ends = [np.inf]
        if model.actuator_ctrllimited[index]:
            ends.append(float(np.min(np.abs(model.actuator_ctrlrange[index]))))
        if model.actuator_forcelimited[index]:
            ends.append(float(np.min(np.abs(model.actuator_forcerange[index]))) / gain)
        if name and np.isfinite(min(ends)):
            words = f"passes on no more than {min(ends):.4g}"
            yield NonlinearElement(f"actuator {name}", name, "", {}, words, None, min(ends))


__all__ = ["imperfect_instruments"]
