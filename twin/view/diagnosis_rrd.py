"""One Rerun recording of a diagnosis: measured, calibrated and explained, the guilty place lit."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from twin.diagnosis.result import Diagnosis, ForcePicture, Trace
from twin.files import write_whole
from twin.model import Motion, Twin
from twin.view.colours import FORCE, IDENTIFIED, MEASURED, REJECTED, TRUE, rgb
from twin.view.diagnosis_words import markdown
from twin.view.rrd import APPLICATION
from twin.view.scene import TIMELINE, log_motion
from twin.view.signals import log_line

Array = NDArray[np.float64]

LIT = (213, 94, 0, 150)
"""Colour of the guilty place."""

TWINS = (("measured", MEASURED), ("calibrated", REJECTED), ("explained", TRUE))


def write_diagnosis_rrd(diagnosis: Diagnosis, path: Path, recording_id: str = "diagnosis") -> Path:
    """Write one test recording beside its simulations, whole or not at all.

    Args:
        diagnosis: what was found.
        path: the .rrd file.
        recording_id: the same id and the same data give the same recording.
    """
    return write_whole(path, lambda part: _write(part, diagnosis, recording_id))


def _write(path: Path, diagnosis: Diagnosis, recording_id: str) -> None:
    trace = next(t for t in diagnosis.traces if t.role == "test")
    stream = rr.RecordingStream(APPLICATION, recording_id=recording_id, send_properties=False)
    stream.save(str(path), default_blueprint=_blueprint(trace))
    motion = _motion(diagnosis.explained, trace)
    log_motion(stream, "frame", motion)
    for finding in diagnosis.findings:
        _light(stream, finding.location, motion)
    _log_signals(stream, trace)
    if diagnosis.force:
        _log_force(stream, diagnosis.force[0])
    text = rr.TextDocument(markdown(diagnosis), media_type="text/markdown")
    stream.log("verdict", text, static=True)
    stream.flush()
    stream.disconnect()


def _motion(twin: Twin, trace: Trace) -> Motion:
    forces = dict(zip(trace.inputs, trace.force.T, strict=True))
    table = forces.pop("acc_ground", None)
    return twin.simulate(forces, trace.sampling_hz, len(trace.force), ground_acceleration=table)


def _light(stream: rr.RecordingStream, place: str, motion: Motion) -> None:
    """Lay a glowing box over the guilty storey, floor or sensor, which moves with the frame."""
    model = motion.model
    digits = "".join(c for c in place.split("+")[0] if c.isdigit())
    floor = f"floor{digits}" if digits else "ground"
    if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, floor) < 0:
        return
    below = f"floor{int(digits) - 1}" if digits and int(digits) > 1 else "ground"
    data = mujoco.MjData(model)
    step = max(1, round(motion.rate_hz / 30))
    rows = range(0, motion.samples, step)
    centres, half = np.empty((len(rows), 3)), np.array([0.17, 0.035, 0.025])
    for number, row in enumerate(rows):
        data.qpos[:] = motion.qpos[row]
        mujoco.mj_kinematics(model, data)
        top, bottom = data.body(floor).xpos, data.body(below).xpos
        if place.startswith("storey"):
            centres[number] = (top + bottom) / 2
            half = np.array([0.17, 0.035, 0.45 * abs(top[2] - bottom[2])])
        else:
            centres[number] = top
    name = f"frame/lit/{place.replace('+', '_')}"
    stream.log(name, rr.Boxes3D.from_fields(half_sizes=[half], colors=[LIT],
                                            fill_mode="Solid"), static=True)  # fmt: skip
    time = np.array([row / motion.rate_hz for row in rows])
    stream.send_columns(
        name,
        [rr.TimeColumn(TIMELINE, duration=time)],
        rr.Boxes3D.columns(centers=centres),
    )


def _log_signals(stream: rr.RecordingStream, trace: Trace) -> None:
    time = np.arange(len(trace.measured)) / trace.sampling_hz

    for column, channel in enumerate(trace.outputs):
        for which, colour in TWINS:
            values = getattr(trace, which)[:, column]
            name = f"signals/{channel}/{which}"
            log_line(stream, name, time, np.nan_to_num(values), which, colour)
    for column, channel in enumerate(trace.inputs):
        log_line(stream, f"force/{channel}", time, trace.force[:, column], channel, FORCE)


def _log_force(stream: rr.RecordingStream, picture: ForcePicture) -> None:
    """Draw the missing force [N] against the drift [mm], both scaled to the same width."""
    x = 1e3 * picture.drift
    wide = max(float(np.max(np.abs(x))), 1e-9)
    tall = max(float(np.max(np.abs(picture.latent))), 1e-9)
    points = np.column_stack([x / wide, -picture.latent / tall])
    root = "missing_force"
    stream.log(
        f"{root}/latent",
        rr.Points2D(points, colors=[rgb(REJECTED)], radii=[0.006]),
        static=True,
    )
    frame = [[[-1.1, 0.0], [1.1, 0.0]], [[0.0, -1.1], [0.0, 1.1]]]
    stream.log(f"{root}/axes", rr.LineStrips2D(frame, colors=[rgb(REJECTED)]), static=True)
    ends = [
        ([1.05, 0.06], f"drift of {picture.place}, {wide:.3g} mm"),
        ([0.05, -1.05], f"force, {tall:.3g} N"),
    ]
    stream.log(
        f"{root}/ends",
        rr.Points2D([p for p, _ in ends], labels=[t for _, t in ends], radii=[0.004]),
        static=True,
    )
    if picture.law is not None:
        curve = np.column_stack([1e3 * picture.law_drift / wide, -picture.law / tall])
        stream.log(
            f"{root}/law",
            rr.LineStrips2D([curve], colors=[rgb(IDENTIFIED)], radii=[0.006]),
            static=True,
        )
    if picture.cycle is not None:
        loop = np.column_stack([1e3 * picture.cycle[:, 0] / wide, -picture.cycle[:, 1] / tall])
        stream.log(
            f"{root}/cycle", rr.LineStrips2D([loop], colors=[rgb(TRUE)], radii=[0.004]), static=True
        )


def _blueprint(trace: Trace) -> rrb.Blueprint:
    plots = [rrb.TimeSeriesView(origin=f"signals/{c}", name=f"{c} [m/s²]") for c in trace.outputs]
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(
                rrb.Spatial3DView(origin="frame", name="explained twin, guilty place lit"),
                rrb.Spatial2DView(origin="missing_force", name="missing force against drift"),
                row_shares=[3, 2],
            ),
            rrb.Vertical(*plots, rrb.TimeSeriesView(origin="force", name="measured force [N]")),
            rrb.TextDocumentView(origin="verdict", name="verdict"),
            column_shares=[3, 4, 3],
        ),
        collapse_panels=True,
    )
