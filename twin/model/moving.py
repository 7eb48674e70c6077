"""What of a model moves: ports of its joints, tendons, bodies and sites, and its bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.model.dashpots import dashpots_noted
from twin.model.port import AXES, Body, Port
from twin.model.rest import Reduced, derivative
from twin.model.tree import hanging_on, height

Array = NDArray[np.float64]
_Jacobian = Callable[[mujoco.MjData], tuple[Array, Array]]
_OBJ, _JOINT = mujoco.mjtObj, mujoco.mjtJoint

STILL = 1e-6
"""What moves less than this share of what moves most in the model does not move: rounding."""

SLIGHT = 1e-3
"""An axis along which an element moves less than this share of its largest motion is no port: it is
a tilt of the rest by less than a thousandth."""


def ports_of(reduced: Reduced, shapes: Array) -> dict[str, Port]:
    """Return every port that something moves.

    Named joints of one freedom and named tendons are drifts (a ball joint has "NAME.rx", ...); a
    dashpot that only says how a structure is damped is none (``twin.model.dashpots``).
    Named bodies (the origin of their frame) and sites move along world axes ("NAME.x") and turn
    about them ("NAME.rx"); one that moves along one axis only is "NAME", unless a joint or tendon
    is called so. Where names meet, the first in the order joint, tendon, body, site has it.

    Args:
        reduced: the model at its equilibrium.
        shapes: coordinates of the freedoms that the rows are wanted in, (freedoms, n).
    """
    model, data = reduced.model, reduced.data
    basis = reduced.basis @ shapes
    jacobians = dict(_jacobians(model, data))
    rows = {key: np.vstack([pair[0], pair[1]]) @ basis for key, pair in jacobians.items()}
    largest = max((float(np.linalg.norm(r, axis=1)[:3].max()) for r in rows.values()), default=0.0)
    extent = float(model.stat.extent) or 1.0
    found: dict[str, Port] = {}
    for port in (*_joints(model, data, basis), *_tendons(model, data, basis)):
        if np.any(np.abs(port.row) > STILL * np.max(np.abs(basis))):
            found.setdefault(port.name, port)
    for (kind, name), row in rows.items():
        size = np.linalg.norm(row, axis=1) * np.repeat([1.0, extent], 3)
        moves = (size > STILL * largest) & (size > SLIGHT * size.max())
        along = [axis for axis in range(3) if moves[axis]]
        for axis in range(6):
            if not moves[axis]:
                continue
            bare = along == [axis] and name not in found
            label = name if bare else f"{name}.{'r' * (axis > 2)}{AXES[axis % 3]}"
            base = np.eye(3)[axis] if axis < 3 else np.zeros(3)
            port = Port(
                label, "motion", row[axis], "rad" if axis > 2 else "m", f"{kind} {name}", base
            )
            found.setdefault(label, port)
    return found


def bodies_of(reduced: Reduced, shapes: Array) -> tuple[dict[str, Body], dict[str, Body]]:
    """Return the bodies and the named sites that move; "body 3" is the third where it has no name.

    Args:
        reduced: the model at its equilibrium, where it is afterwards, too.
        shapes: coordinates of the freedoms that the rows are wanted in, (freedoms, n).
    """
    model, n = reduced.model, reduced.basis.shape[1]
    basis = reduced.basis @ shapes
    largest = float(np.max(np.abs(basis), initial=0.0))
    points = dict(_points(model))

    def heights(y: Array) -> Array:
        """Return what gravity pushes a kilogram at each point with along the freedoms."""
        freedoms = reduced.displaced(y)
        rows = [model.opt.gravity @ at(reduced.data)[0] @ freedoms for at, *_ in points.values()]
        return np.array(rows).ravel()

    weights = np.zeros((len(points), n, n))
    if points and np.any(model.opt.gravity):
        weights = -derivative(heights, n).reshape(len(points), n, n)
        reduced.at_rest()
    found: tuple[dict[str, Body], dict[str, Body]] = ({}, {})
    for ((kind, name), (at, mass, turned)), weight in zip(points.items(), weights, strict=True):
        translation, rotation = (jacobian @ basis for jacobian in at(reduced.data))
        moves = max(np.max(np.abs(translation)), np.max(np.abs(rotation)))
        if moves > STILL * largest:
            weight = shapes.T @ (weight + weight.T) @ shapes / 2
            spin = rotation.T @ turned(reduced.data) @ rotation
            found[kind == "site"][name] = Body(mass, translation, rotation, weight, spin)
    return found


def _points(
    model: mujoco.MjModel,
) -> Iterator[tuple[tuple[str, str], tuple[_Jacobian, float, Callable[[mujoco.MjData], Array]]]]:
    """Yield the centre of every body with mass and every named site: Jacobian, mass, inertia."""

    def of(function: Any, index: int) -> _Jacobian:
        def jacobian(data: mujoco.MjData) -> tuple[Array, Array]:
            translation, rotation = np.zeros((3, model.nv)), np.zeros((3, model.nv))
            function(model, data, translation, rotation, index)
            return translation, rotation

        return jacobian

    def inertia(index: int, data: mujoco.MjData) -> Array:
        axes = data.ximat[index].reshape(3, 3)
        return np.asarray(axes @ np.diag(model.body_inertia[index]) @ axes.T)

    for index in range(1, model.nbody):
        if model.body_mass[index] > 0:
            jacobian, mass = of(mujoco.mj_jacBodyCom, index), float(model.body_mass[index])
            yield ("body", body_name(model, index)), (jacobian, mass, partial(inertia, index))
    for index in range(model.nsite):
        if name := mujoco.mj_id2name(model, _OBJ.mjOBJ_SITE, index):
            yield ("site", name), (of(mujoco.mj_jacSite, index), 0.0, lambda _: np.zeros((3, 3)))


def body_name(model: mujoco.MjModel, index: int) -> str:
    """Return the name of a body, "body 3" for the third where it has none."""
    return mujoco.mj_id2name(model, _OBJ.mjOBJ_BODY, index) or f"body {index}"


def _tree(model: mujoco.MjModel, data: mujoco.MjData, joints: list[int], unit: str) -> Any:
    """Return what a port says of the tree of bodies: what it carries, and its height."""
    bodies = hanging_on(model, joints)
    carries = tuple(body_name(model, i) for i in bodies if model.body_mass[i] > 0)
    return {"carries": carries, "height": height(model, data, joints, unit)}


def _joints(model: mujoco.MjModel, data: mujoco.MjData, basis: Array) -> Iterator[Port]:
    for index in range(model.njnt):
        name = mujoco.mj_id2name(model, _OBJ.mjOBJ_JOINT, index)
        kind, at = model.jnt_type[index], int(model.jnt_dofadr[index])
        if not name:
            continue
        if kind in (int(_JOINT.mjJNT_SLIDE), int(_JOINT.mjJNT_HINGE)):
            unit = "m" if kind == _JOINT.mjJNT_SLIDE else "rad"
            tree = _tree(model, data, [index], unit)
            yield Port(name, "drift", basis[at], unit, f"joint {name}", **tree)
        elif kind == _JOINT.mjJNT_BALL:
            for k, axis in enumerate(AXES):
                yield Port(f"{name}.r{axis}", "drift", basis[at + k], "rad", f"joint {name}")


def _tendons(model: mujoco.MjModel, data: mujoco.MjData, basis: Array) -> Iterator[Port]:
    no_ports = dashpots_noted(model)
    for index in range(model.ntendon):
        name = mujoco.mj_id2name(model, _OBJ.mjOBJ_TENDON, index)
        if name and name not in no_ports:
            row = tendon_row(model, data, index)
            moved = [int(model.dof_jntid[dof]) for dof in np.flatnonzero(row)]
            unit, element = tendon_unit(model, index), f"tendon {name}"
            tree = _tree(model, data, moved, unit) if moved else {}
            yield Port(name, "drift", row @ basis, unit, element, **tree)


def tendon_row(model: mujoco.MjModel, data: mujoco.MjData, index: int) -> Array:
    """Return the length of a tendon for unit joint speeds, (nv,)."""
    row = np.zeros(model.nv)
    start = int(model.ten_J_rowadr[index])
    stop = start + int(model.ten_J_rownnz[index])
    row[model.ten_J_colind[start:stop]] = data.ten_J[start:stop]
    return row


def tendon_unit(model: mujoco.MjModel, index: int) -> str:
    """Return "rad" for a tendon that only adds and subtracts hinges' angles, else "m"."""
    for k in range(model.tendon_adr[index], model.tendon_adr[index] + model.tendon_num[index]):
        hinge = (
            model.wrap_type[k] == mujoco.mjtWrap.mjWRAP_JOINT
            and model.jnt_type[model.wrap_objid[k]] == _JOINT.mjJNT_HINGE
        )
        if not (hinge and abs(model.wrap_prm[k]) == 1):
            return "m"
    return "rad"


def _jacobians(
    model: mujoco.MjModel, data: mujoco.MjData
) -> Iterator[tuple[tuple[str, str], tuple[Array, Array]]]:
    """Yield (kind, name) and the translation and rotation Jacobians, each (3, nv)."""
    elements = (
        ("body", _OBJ.mjOBJ_BODY, model.nbody, mujoco.mj_jacBody),
        ("site", _OBJ.mjOBJ_SITE, model.nsite, mujoco.mj_jacSite),
    )
    for kind, obj, count, jacobian in elements:
        for index in range(count):
            name = mujoco.mj_id2name(model, obj, index)
            if not name or name == "world":
                continue
            translation, rotation = np.zeros((3, model.nv)), np.zeros((3, model.nv))
            jacobian(model, data, translation, rotation, index)
            yield (kind, name), (translation, rotation)
