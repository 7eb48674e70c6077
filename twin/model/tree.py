"""What hangs on a joint or a tendon of a model, and how high it stands over it."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco


def hanging_on(model: mujoco.MjModel, joints: Sequence[int]) -> tuple[int, ...]:
    """Return the bodies that hang on the last of some joints, by their numbers."""
    inside = {int(model.jnt_bodyid[max(joints)])}
    for body in range(min(inside) + 1, model.nbody):
        if int(model.body_parentid[body]) in inside:
            inside.add(body)
    return tuple(sorted(inside))


def height(model: mujoco.MjModel, data: mujoco.MjData, joints: Sequence[int], unit: str) -> float:
    """Return the height of a joint or tendon: what leans over it when it moves [m].

    It is that from the body below to the body above where the port slides, and from the joint to
    the centre of what hangs on it where it turns.

    Args:
        model: compiled.
        data: with positions computed.
        joints: of the port.
        unit: "m" or "rad".
    """
    last = max(joints)
    if unit == "rad":
        bodies = list(hanging_on(model, joints))
        masses = model.body_mass[bodies]
        centre = masses @ data.xipos[bodies, 2] / max(float(masses.sum()), 1e-300)
        return float(centre - data.xanchor[last, 2])
    foot = int(model.body_parentid[min(int(model.jnt_bodyid[joint]) for joint in joints)])
    return float(data.xpos[model.jnt_bodyid[last], 2] - data.xpos[foot, 2])
