"""The names that an MJCF model must have, and what they stand for."""

from __future__ import annotations

import re
from collections.abc import Iterable

import mujoco

from twin.errors import ModelError, available
from twin.place import split_channel

_FLOOR = re.compile(r"^(?:floor|storey|force_floor|acc_floor|disp_floor)([1-9][0-9]{0,3})$")


def _names(model: mujoco.MjModel, kind: mujoco.mjtObj, count: int) -> tuple[str, ...]:
    found = (mujoco.mj_id2name(model, kind, index) for index in range(count))
    return tuple(name for name in found if name)


def names_in(model: mujoco.MjModel) -> dict[str, tuple[str, ...]]:
    """Return the named elements of a compiled model by kind, in the order of the file."""
    kinds = mujoco.mjtObj
    return {
        "body": tuple(n for n in _names(model, kinds.mjOBJ_BODY, model.nbody) if n != "world"),
        "joint": _names(model, kinds.mjOBJ_JOINT, model.njnt),
        "tendon": _names(model, kinds.mjOBJ_TENDON, model.ntendon),
        "actuator": _names(model, kinds.mjOBJ_ACTUATOR, model.nu),
        "sensor": _names(model, kinds.mjOBJ_SENSOR, model.nsensor),
        "equality": _names(model, kinds.mjOBJ_EQUALITY, model.neq),
    }


def floors_of(model: mujoco.MjModel) -> tuple[str, ...]:
    """Return "floor1", "floor2", ... as far as the bodies go."""
    bodies = names_in(model)["body"]
    count = 0
    while f"floor{count + 1}" in bodies:
        count += 1
    return tuple(f"floor{number}" for number in range(1, count + 1))


def channel_sensors(model: mujoco.MjModel) -> dict[str, int]:
    """Return the sensors that are channels of a recording: name -> first column of sensordata."""
    found = {}
    for index in range(model.nsensor):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, index)
        if name and split_channel(name) is not None:
            found[name] = int(model.sensor_adr[index])
    return found


def pendulum_dof(model: mujoco.MjModel) -> int | None:
    """Return the degree of freedom that ``angle_pendulum`` measures, or None without pendulum."""
    sensor = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "angle_pendulum")
    if sensor < 0 or model.sensor_objtype[sensor] != mujoco.mjtObj.mjOBJ_JOINT:
        return None
    return int(model.jnt_dofadr[model.sensor_objid[sensor]])


def _storeys(groups: Iterable[tuple[str, ...]]) -> int:
    """The highest number that any name of the contract carries, at least one."""
    numbers = [int(m[1]) for group in groups for name in group if (m := _FLOOR.match(name))]
    return max(numbers, default=1)


def check_names(model: mujoco.MjModel, source: str) -> None:
    """Check that a model has the names every frame needs.

    Those are the bodies ``ground`` and ``floor1``..``floorN``; for each floor the drift ``storeyI``
    (a joint or a tendon), the actuator ``force_floorI`` and the sensors ``acc_floorI`` and
    ``disp_floorI``.

    Raises:
        ModelError: names are lacking; the message lists them and those of the kind that are there.
    """
    have = names_in(model)
    storeys = _storeys(have[kind] for kind in ("body", "joint", "tendon", "actuator", "sensor"))
    numbers = range(1, storeys + 1)
    needed = {
        "body": ["ground", *(f"floor{i}" for i in numbers)],
        "joint or tendon": [f"storey{i}" for i in numbers],
        "actuator": [f"force_floor{i}" for i in numbers],
        "sensor": [f"{kind}_floor{i}" for i in numbers for kind in ("acc", "disp")],
    }
    there = {**have, "joint or tendon": have["joint"] + have["tendon"]}
    lacks, has = [], []
    for kind, wanted in needed.items():
        missing = [name for name in wanted if name not in there[kind]]
        if missing:
            lacks.append(f"{kind} {', '.join(missing)}")
            has.append(f"{kind}: {available(there[kind])}")
    if lacks:
        raise ModelError(f"{source}: lacks {'; '.join(lacks)}. It has {'; '.join(has)}")
