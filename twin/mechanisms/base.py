"""The base of a MuJoCo model: the body that carries all that moves, and what it moves along."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.errors import ModelError, available
from twin.mechanisms.edits import add_slide, fixed_mass, set_mass
from twin.mechanisms.rest import free_name
from twin.model.port import AXES, GROUND

Array = NDArray[np.float64]


def places_of_base() -> tuple[str, ...]:
    """Return the names that a base has as a place."""
    return (GROUND, *(f"{GROUND}.{axis}" for axis in AXES))


def base_body(spec: mujoco.MjSpec) -> Any:
    """Return the body that everything else stands on: "ground", or the only one in the world.

    Raises:
        ModelError: several bodies stand in the world, so that no one slide moves them all.
    """
    named = spec.body(GROUND)
    if named is not None:
        return named
    roots = [body for body in spec.worldbody.bodies if not body.gravcomp]
    if len(roots) != 1:
        raise ModelError(
            f"no body '{GROUND}' that carries everything: {available([b.name for b in roots])} "
            "stand in the world by themselves"
        )
    return roots[0]


def axis_of(spec: mujoco.MjSpec, place: str) -> Array:
    """Return the world axis of a base's place, (3,).

    "ground" is the only axis that the structure moves along, or x.

    Raises:
        ModelError: the place is no base.
    """
    if place not in places_of_base():
        raise ModelError(f"no place '{place}'; there are {available(places_of_base())}")
    name = place.rpartition(".")[2]
    if name not in AXES:
        name = _only_axis(spec)
    return np.asarray(np.eye(3)[AXES.index(name)])


def free_base(spec: mujoco.MjSpec, mass: float, axis: Array, name: str) -> Any:
    """Let the base slide along an axis, on top of the clamp or the drive that holds it.

    Args:
        spec: the model.
        mass: that moves with the base, all of it [kg].
        axis: in the world, (3,).
        name: of the slide.

    Returns:
        The slide joint, without a spring.

    Raises:
        ModelError: the base moves already.
    """
    body = base_body(spec)
    held = spec.joint(GROUND)
    if held is None and body.joints:
        # what stands in the world moves by itself: the base's mass is that of the slide alone
        slide = add_slide(spec, body, name, axis)
        slide.armature = mass
        if not body.bodies:
            # MuJoCo takes the slides of a body without children for perpendicular ones
            taken = {other.name for other in spec.bodies}
            body.add_body(name=free_name(f"{body.name}_{name}", taken))
        return slide
    if held is not None and not held.armature:
        if spec.equality("clamp") is None:
            raise ModelError(f"{name}: the ground moves already, on a support of its own")
        held.armature = 1.0  # two slides in one body: without it the mass matrix is singular
    set_mass(spec, body, total=mass - fixed_mass(spec, body))
    return add_slide(spec, body, name, axis)


def _only_axis(spec: mujoco.MjSpec) -> str:
    model = spec.copy().compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    moved, jacobian = np.zeros(3), np.zeros((3, model.nv))
    for body in range(1, model.nbody):
        mujoco.mj_jacBodyCom(model, data, jacobian, None, body)
        moved += model.body_mass[body] * np.abs(jacobian).sum(axis=1)
    along = np.flatnonzero(moved > 1e-6 * max(float(moved.max(initial=0.0)), 1e-300))
    return AXES[along[0]] if len(along) == 1 else AXES[0]
