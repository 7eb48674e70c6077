"""What a model's sensors read of motion and inputs: exact Jacobians about the rest.

MuJoCo is asked for its readings at given positions, speeds, accelerations and controls, each varied
by itself, so that a row does not depend on the stiffness of the structure it sits on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.errors import ModelError, available
from twin.model.port import AXES
from twin.model.rest import Reduced, derivative

Array = NDArray[np.float64]
_SENSOR = mujoco.mjtSensor
_FORCES = (int(_SENSOR.mjSENS_FORCE), int(_SENSOR.mjSENS_TORQUE))
_POSITIONS = (int(_SENSOR.mjSENS_FRAMEPOS), int(_SENSOR.mjSENS_SUBTREECOM))
_VELOCITIES = (int(_SENSOR.mjSENS_FRAMELINVEL), int(_SENSOR.mjSENS_SUBTREELINVEL))
_LOCAL = (int(_SENSOR.mjSENS_ACCELEROMETER), int(_SENSOR.mjSENS_VELOCIMETER))
_WORLD = (
    int(_SENSOR.mjSENS_FRAMEPOS),
    int(_SENSOR.mjSENS_FRAMELINVEL),
    int(_SENSOR.mjSENS_FRAMELINACC),
)
STRAIGHT = 1e-3
"""What moves across the x axis by less than this share of its motion along it moves along it."""

_SUFFIXES = {3: AXES, 4: ("w", *AXES)}


def sensor_columns(model: mujoco.MjModel) -> dict[str, int]:
    """Return the channels of all named sensors: name -> column of sensordata.

    A vector sensor has "NAME.x", "NAME.y", "NAME.z" (a quaternion "NAME.w" too), and its bare name
    is its first component: the x axis.
    """
    found: dict[str, int] = {}
    for index in range(model.nsensor):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, index)
        start, size = int(model.sensor_adr[index]), int(model.sensor_dim[index])
        if not name or size == 0:
            continue
        found[name] = start
        if size > 1:
            suffixes = _SUFFIXES.get(size, tuple(str(k + 1) for k in range(size)))
            found |= {f"{name}.{suffix}": start + k for k, suffix in enumerate(suffixes)}
    return found


def channel_columns(reduced: Reduced) -> dict[str, int]:
    """Return the channels that a simulation gives: name -> column of sensordata.

    As ``sensor_columns``, each once: a vector sensor of something that moves along the x axis only
    is its bare name, any other "NAME.x", "NAME.y", "NAME.z".
    """
    model, found = reduced.model, sensor_columns(reduced.model)
    reduced.at_rest()
    for index in range(model.nsensor):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, index)
        if name in found and f"{name}.x" in found:
            if _along_x(reduced, index):
                for axis in AXES:
                    del found[f"{name}.{axis}"]
            else:
                del found[name]
    return found


def _along_x(reduced: Reduced, sensor: int) -> bool:
    """Whether a sensor of translation moves, if at all, along the world's x axis, and faces it."""
    model, data = reduced.model, reduced.data
    translation, rotation = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    target, kind = int(model.sensor_objid[sensor]), int(model.sensor_type[sensor])
    if kind in _LOCAL:
        if data.site_xmat[target][0] < 1 - STRAIGHT:
            return False
        mujoco.mj_jacSite(model, data, translation, rotation, target)
    elif kind in _WORLD and int(model.sensor_refid[sensor]) <= 0:
        if model.sensor_objtype[sensor] == mujoco.mjtObj.mjOBJ_SITE:
            mujoco.mj_jacSite(model, data, translation, rotation, target)
        else:
            mujoco.mj_jacBody(model, data, translation, rotation, target)
    else:
        return False
    size = np.linalg.norm(translation @ reduced.basis, axis=1)
    return bool(max(size[1], size[2]) <= STRAIGHT * size[0])


@dataclass(frozen=True)
class Readings:
    """Sensor rows in the generalised coordinates y of ``Reduced``.

    Attributes:
        rest: readings at rest, (m,).
        Cd, Cv, Ca: readings for unit displacement, velocity, acceleration, (m, n).
        Cu: readings for unit controls directly, (m, nu).
        disp, vel, acc: readings of a translation of everything with its ground along x, y, z and
            of its rates, (m, 3).
    """

    rest: Array
    Cd: Array
    Cv: Array
    Ca: Array
    Cu: Array
    disp: Array
    vel: Array
    acc: Array


def readings(reduced: Reduced, outputs: Sequence[str]) -> Readings:
    """Return the Jacobians of sensors about the rest of ``reduced``.

    Args:
        reduced: a model at its equilibrium.
        outputs: channels, names as ``sensor_columns`` has them.

    Raises:
        ModelError: there is no such sensor, or one cannot be linearised; the message says why.
    """
    sensors = _Sensors(reduced)
    model, basis = sensors.model, reduced.basis
    columns = [_column(model, name) for name in outputs]
    nv, nu, n = model.nv, model.nu, basis.shape[1]
    rest = sensors.read(reduced.qpos)[columns]

    def displaced(y: Array) -> Array:
        return sensors.read(reduced.moved(reduced.qpos, basis @ y))[columns]

    # What moves the readings but displacement is a polynomial of second degree: a unit step is
    # exact, taken from both sides for velocities, whose squares cancel.
    def moving(v: Array) -> Array:
        return (
            sensors.read(reduced.qpos, v)[columns] - sensors.read(reduced.qpos, -v)[columns]
        ) / 2

    zero = np.zeros(nv)
    Cv = [moving(basis[:, k]) for k in range(n)]
    Ca = [sensors.read(reduced.qpos, zero, basis[:, k])[columns] - rest for k in range(n)]
    Cu = [sensors.read(reduced.qpos, zero, zero, unit)[columns] - rest for unit in np.eye(nu)]
    acc = [sensors.read(reduced.qpos, pulled=-axis)[columns] - rest for axis in np.eye(3)]
    disp, vel = np.zeros((len(outputs), 3)), np.zeros((len(outputs), 3))
    for row, column in enumerate(columns):
        disp[row], vel[row] = sensors.sees_base(column)
    m = len(outputs)
    return Readings(
        rest,
        derivative(displaced, n).reshape(m, n),
        np.array(Cv).T.reshape(m, n),
        np.array(Ca).T.reshape(m, n),
        np.array(Cu).T.reshape(m, nu),
        disp,
        vel,
        np.array(acc).T.reshape(m, 3),
    )


def _column(model: mujoco.MjModel, name: str) -> int:
    columns = sensor_columns(model)
    if name not in columns:
        raise ModelError(f"no sensor '{name}'; there are {available(columns)}")
    index = _sensor_at(model, columns[name])
    kinds = (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD))
    tied = [k for k in range(model.neq) if model.eq_active0[k] and model.eq_type[k] in kinds]
    if model.sensor_type[index] in _FORCES and tied:
        tie = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_EQUALITY, tied[0]) or f"{tied[0] + 1}"
        raise ModelError(
            f"sensor '{name}' reads a force that equality constraint {tie} may carry a share of; "
            "that share has no linear equation here. Close the loop by a joint coupling instead"
        )
    return columns[name]


def _sensor_at(model: mujoco.MjModel, column: int) -> int:
    return int(np.searchsorted(model.sensor_adr, column, side="right")) - 1


class _Sensors:
    """Readings at given positions, speeds, accelerations and controls."""

    def __init__(self, reduced: Reduced) -> None:
        self.model, self.data = reduced.model, mujoco.MjData(reduced.model)
        self.gravity = np.array(self.model.opt.gravity)

    def read(
        self,
        qpos: Array,
        qvel: Array | float = 0.0,
        qacc: Array | float = 0.0,
        ctrl: Array | float = 0.0,
        pulled: Array | float = 0.0,
    ) -> Array:
        """Return all readings; ``pulled`` is added to gravity [m/s^2]."""
        model, data = self.model, self.data
        model.opt.gravity[:] = self.gravity + pulled
        data.qpos[:], data.qvel[:], data.ctrl[:] = qpos, qvel, ctrl
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_sensorPos(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_sensorVel(model, data)
        mujoco.mj_fwdActuation(model, data)
        data.efc_force[:] = 0.0
        data.qacc[:] = qacc
        mujoco.mj_rnePostConstraint(model, data)
        mujoco.mj_sensorAcc(model, data)
        model.opt.gravity[:] = self.gravity
        return np.array(data.sensordata)

    def sees_base(self, column: int) -> tuple[Array, Array]:
        """Return what a reading sees of a translation of everything, and of its velocity, (3,)."""
        model = self.model
        index = _sensor_at(model, column)
        kind, axis = model.sensor_type[index], column - model.sensor_adr[index]
        absolute = model.sensor_refid[index] <= 0
        nothing, unit = np.zeros(3), np.eye(3)[axis % 3]
        if kind in _POSITIONS and absolute:
            return unit, nothing
        if kind in _VELOCITIES and absolute:
            return nothing, unit
        if kind == _SENSOR.mjSENS_VELOCIMETER:
            turned = self.data.site_xmat[model.sensor_objid[index]].reshape(3, 3)
            return nothing, np.array(turned[:, axis])
        return nothing, nothing
