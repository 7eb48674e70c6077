"""One Rerun recording of a diagnosis: the twin before and after, the located places lit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import mujoco
import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from twin.diagnosis.result import Diagnosis, ForcePicture, Trace
from twin.errors import TwinError
from twin.files import write_whole
from twin.model import Motion, Twin
from twin.view.chart import TALL, WIDE, Chart
from twin.view.colours import FORCE, IDENTIFIED, LOCATED, MEASURED, REJECTED, TRUE, rgb
from twin.view.diagnosis_words import markdown, place_words, printable, twin_words
from twin.view.figures import unit_of
from twin.view.force_reach import force_reach
from twin.view.located import Region, regions, shares
from twin.view.magnified import factor, magnified, peak
from twin.view.rrd import APPLICATION, DARK, GHOST
from twin.view.scene import DISPLAY_HZ, LONGEST_MOTION_S, TIMELINE, log_motion
from twin.view.signals import log_line
from twin.view.slider import HINT, log_slider, marks, slid

Array = NDArray[np.float64]

FAINTEST, BRIGHTEST = 25, 170
"""Opacity of a place of no and of the whole share, of 255."""

TWINS = (
    ("1_measured", "measured", MEASURED, 4.0),
    ("2_calibrated", "calibrated", IDENTIFIED, 1.6),
    ("3_extended", "explained", TRUE, 1.4),
)
"""Entity, trace, colour and width, in the order in which they are drawn over one another."""

MILLI = {"m": (1e3, "mm", "N"), "rad": (1e3, "mrad", "N m")}
"""Scale and units of a port's motion and force."""


def write_diagnosis_rrd(diagnosis: Diagnosis, path: Path, recording_id: str = "diagnosis") -> Path:
    """Write the recordings beside their simulations, whole or not at all.

    Args:
        diagnosis: what was found.
        path: the .rrd file.
        recording_id: the same id and the same data give the same recording.
    """
    return write_whole(path, lambda part: _write(part, diagnosis, recording_id))


def _write(path: Path, diagnosis: Diagnosis, recording_id: str) -> None:
    stream = rr.RecordingStream(APPLICATION, recording_id=recording_id, send_properties=False)
    log_diagnosis(stream, diagnosis, lambda blueprint: stream.save(str(path), blueprint))
    stream.flush()
    stream.disconnect()


def log_diagnosis(
    stream: rr.RecordingStream, diagnosis: Diagnosis, arrange: Callable[[rrb.Blueprint], None]
) -> None:
    """Log a diagnosis, the motion of the twins included.

    Args:
        stream: to a file or a viewer.
        diagnosis: what was found.
        arrange: called with the arrangement of the views before anything is logged.
    """
    traces = sorted(diagnosis.traces, key=lambda t: t.role != "test")
    trace = traces[0]
    motion, before = _motion(diagnosis.explained, trace), _motion(diagnosis.calibrated, trace)
    by = factor(motion) if motion is not None else 1.0
    arrange(_blueprint(diagnosis, traces, motion, by))
    if before is not None and diagnosis.findings:
        log_motion(stream, "frame/calibrated", magnified(before, by), alpha=GHOST)
        log_slider(stream, "frame/calibrated", before, by, peak(motion) if motion else None)
    if motion is not None:
        shown = magnified(motion, by)
        log_motion(stream, "frame/extended", shown)
        log_slider(stream, "frame/extended", motion, by)
        parts = shares(diagnosis)
        for place, where in regions(diagnosis, parts).items():
            _light(stream, place, where, parts[place], motion, by)
    for number, each in enumerate(traces):
        _log_signals(stream, each, f"recording{number + 1}")
    for picture in located_forces(diagnosis):
        _log_force(stream, picture)
    text = rr.TextDocument(markdown(diagnosis), media_type="text/markdown")
    stream.log("verdict", text, static=True)


def located_forces(diagnosis: Diagnosis) -> list[ForcePicture]:
    """Return the pictures of the missing force at located places; elsewhere none is missing."""
    located = {finding.location for finding in diagnosis.findings}
    return [picture for picture in diagnosis.force if picture.place in located]


def _motion(twin: Twin, trace: Trace) -> Motion | None:
    """Return how a twin moves under a recording's inputs, from rest; None where it runs away."""
    most = round(LONGEST_MOTION_S * trace.sampling_hz)
    forces = dict(zip(trace.inputs, trace.force[:most].T, strict=True))
    ground = {name[-1:] if "." in name else "x": forces.pop(name)
              for name in trace.inputs if name.startswith("acc_ground")}  # fmt: skip
    try:
        samples = min(most, len(trace.force))
        return twin.simulate(forces, trace.sampling_hz, samples, ground_acceleration=ground or None)
    except TwinError:
        return None


def _light(
    stream: rr.RecordingStream, place: str, where: Region, share: float, motion: Motion, by: float
) -> None:
    """Lay a glowing box over a located place, which moves with it, as bright as its share."""
    alpha = round(FAINTEST + (BRIGHTEST - FAINTEST) * share)
    name = f"frame/located/{place.replace('+', '_')}"
    label = f"{place_words(place)}: {100 * share:.0f} %"
    style = rr.Boxes3D.from_fields(
        colors=[(*rgb(LOCATED), alpha)], fill_mode="Solid", labels=[label], show_labels=True
    )
    stream.log(name, style, static=True)
    rows = np.arange(0, motion.samples, max(1, round(motion.rate_hz / DISPLAY_HZ)))
    time = rr.TimeColumn(TIMELINE, duration=rows / motion.rate_hz)
    for poses, times in (
        (magnified(motion, by).qpos[rows], time),
        (slid(motion, by), marks(by)),
    ):
        boxes = _boxes(motion.model, where, poses)
        if boxes is not None:
            fields = rr.Boxes3D.columns(centers=boxes[0], half_sizes=boxes[1])
            stream.send_columns(name, [times], fields)


def _boxes(model: mujoco.MjModel, where: Region, poses: Array) -> tuple[Array, Array] | None:
    """Return centres and half the edges of a place's box, (poses, 3) each; None of no extent."""
    data = mujoco.MjData(model)
    found = []
    for pose in poses:
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        box = where.box(model, data)
        if box is None:
            return None
        found.append(box)
    return np.array([c for c, _ in found]), 1.05 * np.array([h for _, h in found])


def _log_signals(stream: rr.RecordingStream, trace: Trace, root: str) -> None:
    time = np.arange(len(trace.measured)) / trace.sampling_hz
    for column, channel in enumerate(trace.outputs):
        measured = trace.measured[:, column]
        for entity, which, colour, width in TWINS:
            values = np.nan_to_num(getattr(trace, which)[:, column])
            name = f"{root}/signals/{channel}/{entity}"
            said = twin_words(which)
            log_line(stream, name, time, values, said, colour, width)
            if which != "measured":
                name = f"{root}/residual/{channel}/{entity}"
                log_line(stream, name, time, values - measured, said, colour, 1.2)
    for column, channel in enumerate(trace.inputs):
        values = trace.force[:, column]
        log_line(stream, f"{root}/input/{channel}", time, values, channel, FORCE)


def _log_force(stream: rr.RecordingStream, picture: ForcePicture) -> None:
    """Draw the missing force against the motion of its place, and the law with its band."""
    scale, of_motion, of_force = MILLI[picture.unit]
    x = scale * picture.drift
    wide = max(float(np.max(np.abs(x))), 1e-9)
    reach = force_reach(picture) or (0.0, 0.0)
    tall = max(float(np.max(np.abs(reach))), 1e-9)
    place = place_words(picture.place)
    chart = Chart(
        stream, f"missing_force/{picture.place}", (-wide, wide), (-tall, tall),
        f"{place} [{of_motion}]", f"missing force [{of_force}]",
    )  # fmt: skip
    chart.axes()
    shown = np.abs(picture.latent) <= tall
    chart.points("1_latent", x[shown], picture.latent[shown], REJECTED, 0.6)
    if picture.law is not None and picture.law_rate is None:
        grid = scale * picture.law_drift
        inside = np.abs(grid) <= wide
        chart.line("3_law", grid[inside], picture.law[inside], LOCATED, 0.3, above=True)
        if picture.law_std is not None:
            for sign in (-1.96, 1.96):
                edge = picture.law + sign * picture.law_std
                chart.line(f"2_band/{sign:+g}", grid[inside], edge[inside], LOCATED, 0.15)
    elif picture.cycle is not None:
        drift, force = picture.cycle.T
        chart.line("3_cycle", scale * drift, force, LOCATED, 0.4, above=True)


def _blueprint(
    diagnosis: Diagnosis, traces: Sequence[Trace], motion: Motion | None, by: float
) -> rrb.Blueprint:
    ghost = " over calibrated (ghost)" if diagnosis.findings else ""
    frame = rrb.Spatial3DView(
        origin="frame", name=f"extended twin{ghost} x {by:g}; {HINT}",
        background=list(DARK),
        line_grid=rrb.LineGrid3D(visible=False), eye_controls=_eye(motion),
    )  # fmt: skip
    left: list[rrb.View | rrb.Container] = [frame]
    forces = [_force_view(picture) for picture in located_forces(diagnosis)]
    if forces:
        left.append(forces[0] if len(forces) == 1 else rrb.Tabs(*forces))
    recordings = [_signals(trace, f"recording{n + 1}") for n, trace in enumerate(traces)]
    middle = rrb.Tabs(*recordings) if len(recordings) > 1 else recordings[0]
    verdict = rrb.TextDocumentView(origin="verdict", name="verdict")
    return rrb.Blueprint(
        rrb.Horizontal(rrb.Vertical(*left), middle, verdict, column_shares=[3, 4, 3]),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE),
        collapse_panels=True,
    )


def _eye(motion: Motion | None) -> rrb.EyeControls3D:
    """Return a camera that has the whole structure in view."""
    if motion is None:
        return rrb.EyeControls3D()
    model, data = motion.model, mujoco.MjData(motion.model)
    data.qpos[:] = motion.qpos[0]
    mujoco.mj_kinematics(model, data)
    spots = np.vstack([data.xpos[1:], np.zeros((1, 3))]) if model.nbody > 1 else np.zeros((1, 3))
    low, high = spots.min(axis=0), spots.max(axis=0)
    middle, size = (low + high) / 2, max(float(np.max(high - low)), 0.4)
    eye = middle + size * np.array([0.72, -1.22, 0.28])
    return rrb.EyeControls3D(position=eye.tolist(), look_target=middle.tolist())


def _force_view(picture: ForcePicture) -> rrb.View:
    bounds = rrb.VisualBounds2D(x_range=[-22, WIDE + 10], y_range=[-14, TALL + 16])
    return rrb.Spatial2DView(
        origin=f"missing_force/{picture.place}",
        name=f"missing force at {place_words(picture.place)}", visual_bounds=bounds,
    )  # fmt: skip


def _signals(trace: Trace, root: str) -> rrb.Container:
    """Return the views of one recording: every output, what is left of it, and the inputs."""
    views: list[rrb.View] = []
    shares_of: list[float] = []
    for channel in trace.outputs:
        unit = unit_of(channel)
        views += [
            rrb.TimeSeriesView(origin=f"{root}/signals/{channel}", name=f"{channel} [{unit}]"),
            rrb.TimeSeriesView(origin=f"{root}/residual/{channel}",
                               name=f"what is left of {channel} [{unit}]"),
        ]  # fmt: skip
        shares_of += [2, 1]
    views.append(rrb.TimeSeriesView(origin=f"{root}/input", name="inputs"))
    role = "unseen" if trace.role == "test" else "train"
    return rrb.Vertical(*views, row_shares=[*shares_of, 1], name=f"{role}: {printable(trace.name)}")
