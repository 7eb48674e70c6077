"""A MuJoCo model at rest: how its ports move with its joints.

A port is a joint ("column3"), a fixed tendon ("storey2"), a body or a site along or about a world
axis ("floor2.x", "floor2.rz"; without the axis where it moves along one only), or the relative
motion "A-B" of two of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.errors import ModelError, available
from twin.model.moving import tendon_row, tendon_unit
from twin.model.rest import Reduced, settle
from twin.model.tree import hanging_on

Array = NDArray[np.float64]

TRANSLATIONS = ("x", "y", "z")
ROTATIONS = ("rx", "ry", "rz")
SCALAR = (int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtJoint.mjJNT_HINGE))
"""Kinds of joints of one freedom."""

MOVES = 1e-9
"""Share of the largest coefficient below which a joint does not move a port: rounding."""


@dataclass(frozen=True)
class Motion:
    """How a port moves.

    Attributes:
        terms: joint -> coefficient; their sum over the joint positions is the port's motion.
        length: that sum at rest [m or rad].
        unit: "m" or "rad".
        mass: of the bodies that hang on the port's last joint, those it carries [kg].
        mobility: acceleration of the port by a unit force along it [1/kg or 1/(kg m^2)].
        along: what it moves for a unit translation of everything along x, y, z, (3,): zero for a
            relative motion and for a rotation.
    """

    terms: dict[str, float]
    length: float
    unit: str
    mass: float
    mobility: float
    along: Array


class Rest:
    """A compiled copy of a model at its static equilibrium; nothing is changed but names.

    Joints without a name are given one: a tendon needs it.

    Attributes:
        model: the copy.
        data: its state at rest.
        freedoms: what the equality constraints leave free, (nv, n).
        mass: mass matrix of these, (n, n).
    """

    def __init__(self, spec: mujoco.MjSpec) -> None:
        taken = {joint.name for joint in spec.joints}
        for number, joint in enumerate(spec.joints, start=1):
            if not joint.name:
                joint.name = free_name(f"joint_{number}", taken)
                taken.add(joint.name)
        try:
            self.model = spec.copy().compile()
        except ValueError as error:
            raise ModelError(f"does not compile: {error}") from None
        reduced = Reduced(self.model)
        settle(reduced)
        reduced.at_rest()
        self.mass = reduced.mass()
        self.data, self.freedoms = reduced.data, reduced.basis

    def row(self, name: str) -> tuple[Array, str, Array]:
        """Return the port's row on the joint velocities, (nv,), its unit and ``Motion.along``.

        Raises:
            ModelError: there is no such port, or nothing moves it.
        """
        found = self._element(name)
        if found is not None:
            return found
        for cut in (at for at, letter in enumerate(name) if letter == "-"):
            first, second = self._element(name[:cut]), self._element(name[cut + 1 :])
            if first is not None and second is not None:
                if first[1] != second[1]:
                    raise ModelError(f"{name}: the one is in {first[1]}, the other in {second[1]}")
                return first[0] - second[0], first[1], first[2] - second[2]
        raise ModelError(f"no place '{name}'; there are {available(self.names())}")

    def names(self) -> list[str]:
        """Return joints, fixed tendons, and the bodies that move."""
        model, kinds = self.model, mujoco.mjtObj
        out = [model.joint(i).name for i in range(model.njnt) if model.jnt_type[i] in SCALAR]
        out += [model.tendon(i).name for i in range(model.ntendon)]
        for index in range(1, model.nbody):
            body = mujoco.mj_id2name(model, kinds.mjOBJ_BODY, index)
            if body and self.directions(body):
                out.append(body)
        return list(dict.fromkeys(out))

    def directions(self, name: str) -> list[str]:
        """Return "NAME.x" and so on for each world axis that a body or site moves along."""
        jacobian = self._jacobian(name)
        if jacobian is None:
            return []
        free = jacobian[:3] @ self.freedoms
        size = np.linalg.norm(free, axis=1) if free.size else np.zeros(3)
        moves = size > 1e-6 * max(float(size.max()), 1e-9)
        return [f"{name}.{axis}" for axis, is_so in zip(TRANSLATIONS, moves, strict=True) if is_so]

    def motion(self, name: str) -> Motion:
        """Return how a port moves.

        Raises:
            ModelError: no such port, nothing moves it, or a free or a ball joint does.
        """
        row, unit, along = self.row(name)
        model, terms, length = self.model, {}, 0.0
        joints = []
        for joint in range(model.njnt):
            first = int(model.jnt_dofadr[joint])
            kind = model.jnt_type[joint]
            width = 1 if kind in SCALAR else 3 if kind == mujoco.mjtJoint.mjJNT_BALL else 6
            size = float(np.abs(row[first : first + width]).max())
            if size <= MOVES * max(float(np.abs(row).max()), 1e-300):
                continue
            if kind not in SCALAR:
                raise ModelError(
                    f"{name}: it moves with the free or ball joint '{model.joint(joint).name}', "
                    "which no tendon can follow"
                )
            terms[model.joint(joint).name] = float(row[first])
            length += float(row[first] * self.data.qpos[model.jnt_qposadr[joint]])
            joints.append(joint)
        if not terms:
            raise ModelError(f"{name}: nothing moves it; there are {available(self.names())}")
        mass = float(model.body_mass[list(hanging_on(model, joints))].sum())
        free = row @ self.freedoms
        mobility = float(free @ np.linalg.solve(self.mass, free))
        return Motion(terms, length, unit, mass, mobility, along)

    def _element(self, name: str) -> tuple[Array, str, Array] | None:
        model, kinds = self.model, mujoco.mjtObj
        row, axes = np.zeros(model.nv), np.vstack([np.eye(3), np.zeros((3, 3))])
        joint = mujoco.mj_name2id(model, kinds.mjOBJ_JOINT, name)
        if joint >= 0:
            if model.jnt_type[joint] not in SCALAR:
                return None
            row[model.jnt_dofadr[joint]] = 1.0
            slides = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE
            return row, "m" if slides else "rad", np.zeros(3)
        tendon = mujoco.mj_name2id(model, kinds.mjOBJ_TENDON, name)
        if tendon >= 0:
            unit = tendon_unit(model, tendon)
            return tendon_row(model, self.data, tendon), unit, np.zeros(3)
        element, _, axis = name.rpartition(".")
        if element and axis in (*TRANSLATIONS, *ROTATIONS):
            jacobian = self._jacobian(element)
            if jacobian is not None:
                number = (*TRANSLATIONS, *ROTATIONS).index(axis)
                return jacobian[number], "m" if number < 3 else "rad", axes[number]
        jacobian = self._jacobian(name)
        if jacobian is None:
            return None
        along = self.directions(name)
        if len(along) != 1:
            what = f"say which of {available(along)}" if along else "nothing moves it"
            raise ModelError(f"{name}: {what}")
        number = TRANSLATIONS.index(along[0].rpartition(".")[2])
        return jacobian[number], "m", axes[number]

    def _jacobian(self, name: str) -> Array | None:
        """Return how a body's origin or a site moves and turns, (6, nv), None where none is."""
        model, jacobian = self.model, np.zeros((6, self.model.nv))
        body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
        site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, name)
        if body >= 0:
            mujoco.mj_jacBody(model, self.data, jacobian[:3], jacobian[3:], body)
        elif site >= 0:
            mujoco.mj_jacSite(model, self.data, jacobian[:3], jacobian[3:], site)
        else:
            return None
        return jacobian


def free_name(wanted: str, taken: set[str]) -> str:
    """Return a name that is not taken: ``wanted``, or with a number behind it."""
    name, number = wanted, 1
    while name in taken:
        number += 1
        name = f"{wanted}_{number}"
    return name
