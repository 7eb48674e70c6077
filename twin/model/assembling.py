"""From a compiled MJCF model to its linear equations of motion in modal coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from twin.contract import names_in
from twin.errors import ModelError, available
from twin.model.linear import LinearModel
from twin.model.moving import STILL, bodies_of, ports_of
from twin.model.port import AXES, Base, Body, Port, ground_inputs
from twin.model.rest import Reduced, derivative, settle, symmetric
from twin.model.sensing import readings, sensor_columns
from twin.model.truncation import kept_shapes, left_out

Array = NDArray[np.float64]


def linear_model(
    model: mujoco.MjModel,
    inputs: Sequence[str],
    outputs: Sequence[str],
    band_hz: float | None = None,
) -> LinearModel:
    """Return the exact linear equations of a model about its rest under gravity.

    Args:
        model: a compiled model.
        inputs: actuators (forces, torques) and "acc_ground", "acc_ground.x", ... .
        outputs: sensors as ``sensor_columns`` names them. A sensor of absolute position or velocity
            reads relative to the ground where that is shaken.
        band_hz: highest frequency that matters [Hz]; modes far above it are then left out but for
            their static share (``twin.model.truncation``). None keeps all of a model of at most 40
            freedoms, and the band of the slowest 40 modes of a larger one.

    Raises:
        ModelError: no rest, nothing that moves, no such input or output (the message lists those
            there are), an actuator with dynamics of its own, or a ground that does not carry all.
    """
    if model.nv == 0:
        raise ModelError("the model has no joint: nothing moves")
    reduced = Reduced(model)
    n = reduced.basis.shape[1]
    if n == 0:
        raise ModelError("the equality constraints leave nothing that moves")
    settle(reduced)
    K = symmetric(-derivative(reduced.force, n))
    R = symmetric(-derivative(reduced.force_at_speed, n))
    M = symmetric(reduced.mass())
    stiffness, shapes = linalg.eigh((K + K.T) / 2, M)
    stiffness[np.abs(stiffness) < 1e-12 * np.max(np.abs(stiffness), initial=0.0)] = 0.0
    reduced.at_rest()
    ports = ports_of(reduced, shapes)
    bodies, sites = bodies_of(reduced, shapes)
    sensed = readings(reduced, outputs)
    reduced.at_rest()
    still = np.sqrt(sum(body.mass for body in bodies.values())) * STILL
    controls, outside = reduced.control_forces()
    columns = {
        name: control_of(model, name) for name in inputs if name in names_in(model)["actuator"]
    }
    base = {}
    for axis, name in enumerate(AXES if stands(model) else ()):
        row = sum((b.mass * b.translation[axis] for b in bodies.values()), start=np.zeros(n))
        if np.linalg.norm(row) > still:
            seen = (sensed.disp[:, axis], sensed.vel[:, axis], sensed.acc[:, axis])
            push = [outside[axis, columns[i]] if i in columns else 0.0 for i in inputs]
            base[name] = Base(*_masses(model, bodies), row, *seen, np.array(push))
    B, Cu = np.zeros((n, len(inputs))), np.zeros((len(outputs), len(inputs)))
    shaken = {column: axis for axis, column in ground_inputs(tuple(inputs), base).items()}
    grounds = [name for name in inputs if name in ground_names(base)]
    if len(grounds) > len(shaken):
        raise ModelError(f"the ground is shaken along the same axis twice: {available(grounds)}")
    for column, name in enumerate(inputs):
        if name in ground_names(base):
            ground = base[shaken[column]]
            B[:, column], Cu[:, column] = -ground.row, ground.acc
        elif name in columns:
            control = columns[name]
            B[:, column], Cu[:, column] = shapes.T @ controls[:, control], sensed.Cu[:, control]
        else:
            there = available((*names_in(model)["actuator"], *ground_names(base)))
            raise ModelError(f"no actuator '{name}'; inputs are {there}")
    coordinates = tuple(f"q{k + 1}" for k in range(n))
    full = LinearModel(
        M=np.eye(n),
        R=shapes.T @ R @ shapes,
        K=np.diag(stiffness) + _skew(shapes.T @ K @ shapes),
        inputs=tuple(inputs),
        B=B,
        outputs=tuple(outputs),
        Cd=sensed.Cd @ shapes,
        Cv=sensed.Cv @ shapes,
        Ca=sensed.Ca @ shapes,
        Cu=Cu,
        ports=ports,
        bodies=bodies,
        sites=sites,
        driven=_driven(model, inputs, ports),
        base=base,
        rest=sensed.rest,
        coordinates=coordinates,
        shapes=reduced.basis @ shapes,
    )
    T = kept_shapes(full, stiffness, band_hz)
    return full if T is None else full.within(T, left_out(full, stiffness, T))


def _driven(
    model: mujoco.MjModel, inputs: Sequence[str], ports: Mapping[str, Port]
) -> dict[str, str]:
    """Return the actuators among the inputs that drive a joint -> the joint, which is a port."""
    found = {}
    for index in np.flatnonzero(model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, index)
        joint = mujoco.mj_id2name(
            model, mujoco.mjtObj.mjOBJ_JOINT, int(model.actuator_trnid[index, 0])
        )
        if name in inputs and joint in ports:
            found[name] = joint
    return found


def ground_names(base: Mapping[str, Base]) -> tuple[str, ...]:
    """Return the names that a shaken ground's acceleration can have as an input."""
    if not base:
        return ()
    bare = ("acc_ground",) if len(base) == 1 or AXES[0] in base else ()
    return (*bare, *(f"acc_ground.{axis}" for axis in base))


def control_of(model: mujoco.MjModel, name: str) -> int:
    """Return which control an actuator's value is.

    Raises:
        ModelError: the actuator has dynamics of its own.
    """
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, name)
    kinds = (int(mujoco.mjtDyn.mjDYN_NONE), int(mujoco.mjtDyn.mjDYN_INTEGRATOR))
    if model.actuator_dyntype[index] not in kinds:
        raise ModelError(
            f"actuator '{name}' has dynamics of its own; its value is no force that can be measured"
        )
    if model.actuator_ctrlnum[index] != 1:
        raise ModelError(f"actuator '{name}' has {model.actuator_ctrlnum[index]} controls, not one")
    return int(model.actuator_ctrladr[index])


def stands(model: mujoco.MjModel) -> bool:
    """Whether everything stands on the ground: no body floats on a free joint."""
    return not np.any(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)


def _masses(model: mujoco.MjModel, bodies: Mapping[str, Body]) -> tuple[float, float]:
    moving = sum(body.mass for body in bodies.values())
    total = float(model.body_mass[1:].sum())
    return total, total - moving


def _skew(K: Array) -> Array:
    """Return the part of a stiffness that is not symmetric (a servo that follows another joint)."""
    return np.asarray((K - K.T) / 2)


__all__ = ["linear_model", "sensor_columns"]
