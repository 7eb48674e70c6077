"""What the sensors and actuators of a compiled MJCF model measure, as kinds of channels."""

from __future__ import annotations

import mujoco

_S = mujoco.mjtSensor
_BALL, _HINGE = int(mujoco.mjtJoint.mjJNT_BALL), int(mujoco.mjtJoint.mjJNT_HINGE)
_VECTOR = {
    _S.mjSENS_ACCELEROMETER: "acc",
    _S.mjSENS_VELOCIMETER: "vel",
    _S.mjSENS_GYRO: "rate",
    _S.mjSENS_FORCE: "force",
    _S.mjSENS_TORQUE: "torque",
    _S.mjSENS_BALLANGVEL: "rate",
    _S.mjSENS_FRAMEPOS: "disp",
    _S.mjSENS_FRAMELINVEL: "vel",
    _S.mjSENS_FRAMELINACC: "acc",
    _S.mjSENS_FRAMEANGVEL: "rate",
    _S.mjSENS_FRAMEANGACC: "angacc",
    _S.mjSENS_SUBTREECOM: "disp",
    _S.mjSENS_SUBTREELINVEL: "vel",
}
_SCALAR = {
    _S.mjSENS_TENDONPOS: "disp",
    _S.mjSENS_TENDONVEL: "vel",
    _S.mjSENS_TENDONLIMITPOS: "disp",
    _S.mjSENS_TENDONLIMITVEL: "vel",
    _S.mjSENS_TENDONLIMITFRC: "force",
    _S.mjSENS_TENDONACTFRC: "force",
    _S.mjSENS_RANGEFINDER: "disp",
}
_AT_JOINT = {
    _S.mjSENS_JOINTPOS: ("disp", "angle"),
    _S.mjSENS_JOINTVEL: ("vel", "rate"),
    _S.mjSENS_JOINTLIMITPOS: ("disp", "angle"),
    _S.mjSENS_JOINTLIMITVEL: ("vel", "rate"),
    _S.mjSENS_JOINTLIMITFRC: ("force", "torque"),
    _S.mjSENS_JOINTACTFRC: ("force", "torque"),
}
_AT_ACTUATOR = {
    _S.mjSENS_ACTUATORPOS: ("disp", "angle"),
    _S.mjSENS_ACTUATORVEL: ("vel", "rate"),
    _S.mjSENS_ACTUATORFRC: ("force", "torque"),
}


def channel_kinds(model: mujoco.MjModel) -> dict[str, str]:
    """Return the kind of every named sensor and actuator.

    A vector sensor stands there by its name, which is its x axis, and as NAME.x, NAME.y, NAME.z.
    An actuator's kind is that of what it applies: a force, or a torque about a hinge.

    Args:
        model: compiled.

    Returns:
        Channel name -> kind (``twin.quantity``), "other" for sensors of other quantities.
    """
    found = {}
    for index in range(model.nsensor):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, index)
        if name:
            kind = sensor_kind(model, index)
            found[name] = kind
            if model.sensor_dim[index] == 3:
                found.update({f"{name}.{axis}": kind for axis in "xyz"})
    for index in range(model.nu):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, index)
        if name:
            found[name] = ("force", "torque")[_turns(model, index)]
    return found


def sensor_kind(model: mujoco.MjModel, index: int) -> str:
    """Return the kind of the sensor with this index, "other" for none of ours."""
    kind, at = _S(int(model.sensor_type[index])), int(model.sensor_objid[index])
    if kind in _AT_JOINT:
        return _AT_JOINT[kind][int(model.jnt_type[at] == _HINGE)]
    if kind in _AT_ACTUATOR:
        return _AT_ACTUATOR[kind][_turns(model, at)]
    return _VECTOR.get(kind, _SCALAR.get(kind, "other"))


def _turns(model: mujoco.MjModel, actuator: int) -> bool:
    """Return whether an actuator turns something: its joint is a hinge or a ball."""
    joints = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    acts_on = mujoco.mjtTrn(int(model.actuator_trntype[actuator]))
    if acts_on not in joints:
        gear = model.actuator_gear[actuator]
        at_site = acts_on == mujoco.mjtTrn.mjTRN_SITE
        return bool(at_site and gear[3:].any() and not gear[:3].any())
    joint = int(model.actuator_trnid[actuator, 0])
    return bool(model.jnt_type[joint] in (_BALL, _HINGE))
