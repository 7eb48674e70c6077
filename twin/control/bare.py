"""The rig taken apart: the pendulum's data, and the frame without it."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

import mujoco
import numpy as np

from twin.control.plant import ANGLE
from twin.errors import ControlError
from twin.frame import Pendulum
from twin.model import Twin


def pendulum_of(twin: Twin) -> Pendulum:
    """Return the pendulum's data as the model file has them, the inertia about the centre.

    Raises:
        ControlError: the model has no pendulum.
    """
    model = twin.compile()
    body = _pendulum_body(model, twin.source)
    axis = model.joint(model.body_jntadr[body]).axis
    frame = np.zeros(9)
    mujoco.mju_quat2Mat(frame, model.body_iquat[body])
    along = frame.reshape(3, 3).T @ axis
    return Pendulum(
        mass=float(model.body_mass[body]),
        centre_distance=float(np.linalg.norm(model.body_ipos[body])),
        inertia=float(np.sum(model.body_inertia[body] * along**2)),
        damping=float(model.dof_damping[model.body_dofadr[body]]),
    )


def without_pendulum(twin: Twin) -> Twin:
    """Return the bare frame, as it is hit before the pendulum is mounted.

    Raises:
        ControlError: the model has no pendulum.
    """
    model = twin.compile()
    name = model.body(_pendulum_body(model, twin.source)).name
    root = ElementTree.fromstring(twin.mjcf)
    joints: set[str | None] = set()
    for parent in list(root.iter()):
        for body in [child for child in parent if child.get("name") == name]:
            if body.tag == "body":
                joints |= {joint.get("name") for joint in body.iter("joint")}
                parent.remove(body)
    for section in root.findall("actuator") + root.findall("sensor"):
        for element in [child for child in section if child.get("joint") in joints]:
            section.remove(element)
    others = tuple(m for m in twin.mechanisms if m.on != "actuator")
    return replace(twin, mjcf=ElementTree.tostring(root, encoding="unicode"), mechanisms=others)


def _pendulum_body(model: mujoco.MjModel, source: str) -> int:
    sensor = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, ANGLE)
    if sensor < 0 or model.sensor_objtype[sensor] != mujoco.mjtObj.mjOBJ_JOINT:
        raise ControlError(f"{source}: no pendulum, there is no joint sensor '{ANGLE}'")
    return int(model.jnt_bodyid[model.sensor_objid[sensor]])
