"""Motion magnified, so that a tenth of a millimetre is seen."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.model import Motion

Array = NDArray[np.float64]

VISIBLE = 0.08
"""Largest displacement that is shown, as a share of the structure's size."""

STEPS = (1, 2, 5)
SEVERAL = 400
"""Moments of a motion that are looked at for its largest displacement."""


def factor(motion: Motion) -> float:
    """Return by how much a motion is magnified: 1, 2, 5, 10, 20, ... so that it is visible."""
    largest, extent = _largest(motion)
    if not largest > 0:
        return 1.0
    wanted = VISIBLE * extent / largest
    if wanted <= 1:
        return 1.0
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(max(step * power for step in STEPS if step * power <= wanted))


def magnified(motion: Motion, by: float) -> Motion:
    """Return the motion with every joint's distance from the model's rest magnified."""
    if by == 1:
        return motion
    model = motion.model
    rest = motion.qpos[0]
    qpos = np.array([moved(model, rest, q, by) for q in motion.qpos])
    return replace(motion, qpos=qpos)


def moved(model: mujoco.MjModel, rest: Array, qpos: Array, by: float) -> Array:
    """Return joint positions ``by`` times as far from those at rest, (nq,)."""
    way, out = np.zeros(model.nv), np.array(rest)
    mujoco.mj_differentiatePos(model, way, 1.0, rest, qpos)
    mujoco.mj_integratePos(model, out, way, by)
    return out


def peak(motion: Motion) -> int:
    """Return the sample at which the structure is farthest from where it began."""
    return int(np.argmax(np.linalg.norm(motion.qpos - motion.qpos[0], axis=1)))


def _largest(motion: Motion) -> tuple[float, float]:
    """Return the largest displacement of a body, and the structure's size [m]."""
    model = motion.model
    data = mujoco.MjData(model)

    def places(row: int) -> Array:
        data.qpos[:] = motion.qpos[row]
        mujoco.mj_kinematics(model, data)
        return data.xpos[1:].copy()

    first = places(0)
    every = max(1, motion.samples // SEVERAL)
    rows = {*range(0, motion.samples, every), peak(motion)}
    largest = max(float(np.max(np.linalg.norm(places(r) - first, axis=1), initial=0)) for r in rows)
    moving = np.array([bool(model.body_weldid[b]) for b in range(1, model.nbody)])
    around = np.vstack([np.zeros((1, 3)), first[moving]]) if moving.any() else np.zeros((1, 3))
    extent = float(np.max(np.ptp(around, axis=0), initial=0.0))
    return largest, extent or float(model.stat.extent)
