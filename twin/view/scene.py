"""A MuJoCo model in Rerun: its geometry once, its poses over time, its bending beams as meshes."""

from __future__ import annotations

import mujoco
import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twin.model import Motion

Array = NDArray[np.float64]

DISPLAY_HZ = 30.0
TIMELINE = "time"
LONGEST_MOTION_S = 300.0
"""Beyond this a motion stands still: a record may last for hours [s]."""

BEAM_COLOUR = (230, 159, 0)


def log_motion(
    stream: rr.RecordingStream,
    root: str,
    motion: Motion,
    start_s: float = 0.0,
    alpha: float = 1.0,
) -> None:
    """Log the moving frame under ``root``: static geometry, poses and skins at 30 Hz.

    A motion of more than ``LONGEST_MOTION_S`` is shown up to there.

    Args:
        stream: the Rerun recording.
        root: entity path.
        motion: what moves.
        start_s: time of its first sample [s]; what lies before zero is left out.
        alpha: opacity; a ghost has less than one.
    """
    model = motion.model
    step = max(round(motion.rate_hz / DISPLAY_HZ), 1)
    first = max(round(-start_s * motion.rate_hz), 0)
    last = min(motion.samples, first + round(LONGEST_MOTION_S * motion.rate_hz))
    frames = np.arange(first, last, step)
    for body in range(model.nbody):
        _log_geoms(stream, _entity(root, model, body), model, body, alpha)
    for skin in range(model.nskin):
        _log_skin(stream, f"{root}/skins/{skin}", model, skin, alpha)
    time = rr.TimeColumn(TIMELINE, duration=start_s + frames / motion.rate_hz)
    log_poses(stream, root, model, motion.qpos[frames], time)


def log_poses(
    stream: rr.RecordingStream, root: str, model: mujoco.MjModel, qpos: Array, times: rr.TimeColumn
) -> None:
    """Log where bodies and skins are, along a timeline; their geometry is logged elsewhere.

    Args:
        stream: the Rerun recording.
        root: entity path.
        model: what moves.
        qpos: joint positions, (poses, nq).
        times: one of each pose.
    """
    data = mujoco.MjData(model)
    positions = np.empty((len(qpos), model.nbody, 3))
    rotations = np.empty((len(qpos), model.nbody, 4))
    for row, pose in enumerate(qpos):
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        positions[row], rotations[row] = data.xpos, data.xquat
    for body in range(model.nbody):
        if body:
            stream.send_columns(
                _entity(root, model, body),
                [times],
                rr.Transform3D.columns(
                    translation=positions[:, body],
                    # MuJoCo puts the scalar first, Rerun last.
                    quaternion=rotations[:, body][:, [1, 2, 3, 0]],
                ),
            )
    for skin in range(model.nskin):
        vertices = _skin_vertices(model, skin, positions, rotations)
        stream.send_columns(
            f"{root}/skins/{skin}",
            [times],
            rr.Mesh3D.columns(vertex_positions=vertices.reshape(-1, 3)).partition(
                np.full(len(qpos), vertices.shape[1])
            ),
        )


def _entity(root: str, model: mujoco.MjModel, body: int) -> str:
    return f"{root}/{model.body(body).name or f'body{body}'}"


def _log_geoms(
    stream: rr.RecordingStream, name: str, model: mujoco.MjModel, body: int, alpha: float
) -> None:
    boxes, rods, balls = (
        mujoco.mjtGeom.mjGEOM_BOX,
        mujoco.mjtGeom.mjGEOM_CYLINDER,
        (mujoco.mjtGeom.mjGEOM_SPHERE),
    )
    capsules = mujoco.mjtGeom.mjGEOM_CAPSULE
    mine = np.flatnonzero(model.geom_bodyid == body)
    for kind in (boxes, rods, balls, capsules):
        geoms = [int(g) for g in mine if model.geom_type[g] == kind]
        if not geoms:
            continue
        size = model.geom_size[geoms]
        place = {
            "centers": model.geom_pos[geoms],
            "quaternions": model.geom_quat[geoms][:, [1, 2, 3, 0]],
            "colors": [_faded(_colour(model, g), alpha) for g in geoms],
            "fill_mode": "solid",
        }
        if kind == boxes:
            shape = rr.Boxes3D(half_sizes=size, **place)
        elif kind == rods:
            shape = rr.Cylinders3D(lengths=2 * size[:, 1], radii=size[:, 0], **place)
        elif kind == balls:
            shape = rr.Ellipsoids3D(half_sizes=np.repeat(size[:, :1], 3, axis=1), **place)
        else:
            # Rerun's capsules start at their lower end, MuJoCo's are centred.
            low = np.array([_up(model.geom_quat[g]) * model.geom_size[g, 1] for g in geoms])
            shape = rr.Capsules3D(
                lengths=2 * size[:, 1],
                radii=size[:, 0],
                translations=model.geom_pos[geoms] - low,
                quaternions=place["quaternions"],
                colors=place["colors"],
            )
        stream.log(f"{name}/{_label(kind)}", shape, static=True)


def _label(kind: int) -> str:
    return str(mujoco.mjtGeom(kind).name).removeprefix("mjGEOM_").lower()


def _up(quaternion: Array) -> Array:
    up = np.zeros(3)
    mujoco.mju_rotVecQuat(up, np.array([0.0, 0.0, 1.0]), quaternion)
    return up


def _colour(model: mujoco.MjModel, geom: int) -> tuple[int, ...]:
    material = model.geom_matid[geom]
    rgba = model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom]
    return tuple(int(255 * c) for c in rgba)


def _faded(colour: tuple[int, ...], alpha: float) -> list[int]:
    return [*colour[:3], round(alpha * (colour[3] if len(colour) > 3 else 255))]


def _log_skin(
    stream: rr.RecordingStream,
    name: str,
    model: mujoco.MjModel,
    skin: int,
    alpha: float,
) -> None:
    """Log a skin's triangles."""
    at, faces = model.skin_faceadr[skin], model.skin_facenum[skin]
    triangles = model.skin_face[at : at + faces]
    material = model.skin_matid[skin]
    rgba = model.mat_rgba[material] if material >= 0 else model.skin_rgba[skin]
    stream.log(
        name,
        rr.Mesh3D.from_fields(
            triangle_indices=triangles,
            albedo_factor=_faded(tuple(int(255 * c) for c in rgba), alpha),
        ),
        static=True,
    )


def _skin_vertices(model: mujoco.MjModel, skin: int, positions: Array, rotations: Array) -> Array:
    """Return where a skin's vertices are, (poses, vertices, 3).

    Every vertex follows its bones by their weights, as MuJoCo draws it.
    """
    start, count = model.skin_vertadr[skin], model.skin_vertnum[skin]
    rest = model.skin_vert[start : start + count]
    vertices = np.zeros((len(positions), count, 3))
    first = model.skin_boneadr[skin]
    for bone in range(first, first + model.skin_bonenum[skin]):
        body = model.skin_bonebodyid[bone]
        at = model.skin_bonevertadr[bone]
        touched = slice(at, at + model.skin_bonevertnum[bone])
        index, weight = model.skin_bonevertid[touched], model.skin_bonevertweight[touched]
        back = np.empty(9)
        mujoco.mju_quat2Mat(back, model.skin_bonebindquat[bone].astype(float))
        local = (rest[index] - model.skin_bonebindpos[bone]) @ back.reshape(3, 3)
        for row in range(len(positions)):
            turn = np.empty(9)
            mujoco.mju_quat2Mat(turn, rotations[row, body])
            moved = local @ turn.reshape(3, 3).T + positions[row, body]
            vertices[row, index] += weight[:, None] * moved
    return vertices
