"""One Rerun recording of an identification: identified over true, with a blueprint that fits."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import mujoco
import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from twin.files import write_whole
from twin.identification.at_sensors import modes_at_sensors
from twin.identification.result import Identification
from twin.laboratory import Performance
from twin.model import Motion, Twin
from twin.view import figures, rrd_charts
from twin.view.colours import FORCE, IDENTIFIED, MEASURED, SERIES, TRUE
from twin.view.comparison import matrices_of, matrix_rows, modal_rows, paired_modes
from twin.view.deflection import aligned, mode_shapes
from twin.view.diagnosis_words import printable
from twin.view.identified_motion import FloorMotion, identified_motion, true_motion
from twin.view.line_frame import MODE_SPACING, log_line_frame, log_mode, log_mode_label
from twin.view.magnified import factor, magnified, peak
from twin.view.scene import DISPLAY_HZ, TIMELINE, log_motion
from twin.view.signals import log_line
from twin.view.slider import HINT, factors, log_slider, marks
from twin.view.tables import BOUND_NOTE, markdown_table

Array = NDArray[np.float64]

APPLICATION = "frame-twin"

GHOST = 0.35
"""Opacity of the true frame, which stands behind the identified one."""

DARK = (18, 20, 24)


def write_rrd(
    path: Path,
    result: Identification,
    truth: Twin | None = None,
    performance: Performance | None = None,
    recording_id: str = "identification",
) -> Path:
    """Write the recording whole or not at all.

    Args:
        path: the .rrd file.
        result: what was identified.
        truth: the twin the recording was made on, shown as the true parameters, or None.
        performance: the virtual test, whose motion is shown, or None.
        recording_id: the same id and the same data give the same recording.
    """
    return write_whole(path, lambda part: _write(part, result, truth, performance, recording_id))


def _write(
    path: Path,
    result: Identification,
    truth: Twin | None,
    performance: Performance | None,
    recording_id: str,
) -> None:
    motion, start_s = None, 0.0
    if performance is not None:
        motion, start_s = performance.motion, performance.start_s
    elif truth is not None:
        motion = true_motion(result, truth)
    mine = identified_motion(result)
    by = factor(motion) if motion is not None else _own_factor(mine)
    stream = rr.RecordingStream(APPLICATION, recording_id=recording_id, send_properties=False)
    charts = rrd_charts.views(result, truth)
    stream.save(str(path), default_blueprint=_blueprint(result, motion, mine, by, charts))
    if motion is not None:
        log_motion(stream, "frame/true", magnified(motion, by), start_s, GHOST)
        log_slider(stream, "frame/true", motion, by)
    if mine is not None:
        step = max(1, round(mine.rate_hz / DISPLAY_HZ))
        time = np.arange(0, len(mine.x), step) / mine.rate_hz
        heights = _heights(motion, mine.x.shape[1])
        log_line_frame(stream, "frame/identified", time, by * mine.x[::step], IDENTIFIED,
                       heights=heights)  # fmt: skip
        # the same moment as that of the true frame, whose motion may begin before the recording
        out = np.argmax(np.linalg.norm(mine.x, axis=1)) if motion is None else round(
            (start_s + peak(motion) / motion.rate_hz) * mine.rate_hz)  # fmt: skip
        moment = mine.x[int(np.clip(out, 0, len(mine.x) - 1))]
        log_line_frame(stream, "frame/identified", np.zeros(0),
                       np.outer(factors(by), moment), IDENTIFIED, heights=heights,
                       times=marks(by))  # fmt: skip
    _log_modes(stream, result, truth, by)
    for number in range(len(result.recordings)):
        _log_signals(stream, result, number)
    rrd_charts.log(stream, result, truth)
    text = rr.TextDocument(summary(result, truth), media_type="text/markdown")
    stream.log("parameters", text, static=True)
    stream.flush()
    stream.disconnect()


def _heights(motion: Motion | None, levels: int) -> Array | None:
    """Return how high ground and floors of the true frame stand [m], (levels,)."""
    names = ["ground", *(f"floor{level}" for level in range(1, levels))]
    if motion is None:
        return None
    model, data = motion.model, mujoco.MjData(motion.model)
    data.qpos[:] = motion.qpos[0]
    mujoco.mj_kinematics(model, data)
    found = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name) for name in names]
    return np.array([data.xpos[body, 2] for body in found]) if min(found) >= 0 else None


def _own_factor(mine: FloorMotion | None) -> float:
    largest = float(np.max(np.abs(mine.x))) if mine is not None else 0.0
    return float(10 ** np.floor(np.log10(0.03 / largest))) if 0 < largest < 0.03 else 1.0


def _log_modes(
    stream: rr.RecordingStream, result: Identification, truth: Twin | None, by: float
) -> None:
    seconds = result.recordings[0].duration_s
    true_modes = truth.modes() if truth is not None else None
    pairs = paired_modes(result.modal, true_modes)
    theirs = mode_shapes(true_modes) if true_modes is not None else []
    for number, mode in enumerate(mode_shapes(result.modal)):
        root = f"modes/mode{number + 1}"
        log_mode(stream, f"{root}/identified", mode, number, seconds, IDENTIFIED, still=marks(by))
        log_mode_label(stream, f"{root}/label", mode, number)
        pair = pairs[number]
        if pair is not None and len(theirs[pair].places) == len(mode.places):
            shape = aligned(theirs[pair], mode)
            log_mode(stream, f"{root}/true", shape, number, seconds, TRUE, behind=True,
                     still=marks(by))  # fmt: skip


def summary(result: Identification, truth: Twin | None) -> str:
    """Return identified against true parameters and the notes, as Markdown."""
    modal = modal_rows(result, modes_at_sensors(truth, result.outputs) if truth else None)
    matrices = matrix_rows(result.second_order, matrices_of(truth), result.second_order_std)
    parts = ["# Identified parameters", markdown_table(modal), markdown_table(matrices)]
    parts += [BOUND_NOTE, f"Estimate: {result.route}.", f"Error: {100 * result.nrmse:.2f} % of RMS"]
    parts += [f"- {note}" for note in result.notes]
    return "\n\n".join(part for part in parts if part)


def _log_signals(stream: rr.RecordingStream, result: Identification, number: int) -> None:
    """Log one recording under an entity of its own: measured first, which the others lie on."""
    recording, predicted = result.recordings[number], result.predicted[number]
    root = f"recording{number + 1}"

    def line(name: str, values: Array, label: str, colour: str, width: float) -> None:
        log_line(stream, f"{root}/{name}", recording.time, values, label, colour, width)

    for name in result.inputs:
        if name in recording.names:
            line(f"signals/{name}/1_measured", recording.column(name), "measured", FORCE, 1.5)
    for column, name in enumerate(result.outputs):
        measured = recording.column(name)
        line(f"signals/{name}/1_measured", measured, "measured", MEASURED, 3.5)
        again = predicted[:, column]
        line(f"signals/{name}/2_resimulated", again, "re-simulated", IDENTIFIED, 1.2)
        line(f"residual/{name}", measured - again, name, SERIES[column % len(SERIES)], 1.0)


def _blueprint(
    result: Identification,
    motion: Motion | None,
    mine: FloorMotion | None,
    by: float,
    charts: Mapping[str, rrb.View | rrb.Container],
) -> rrb.Blueprint:
    left: list[rrb.View] = []
    if motion is not None or mine is not None:
        who = "identified (orange) over true" if motion is not None and mine is not None else (
            "true frame" if motion is not None else "identified frame"
        )  # fmt: skip
        left.append(_solid("frame", f"{who} x {by:g}; {HINT}", *_before(motion, result)))
    count, levels = len(result.modal.natural_freq), len(_places(result))
    if count and levels > 1:
        across = 0.5 * MODE_SPACING * (count - 1)
        far = 1.15 * max(MODE_SPACING * count + 0.1, 0.3 * levels + 0.1)
        eye, target = [across, -far, 0.15 * levels], [across, 0, 0.14 * levels]
        title = "mode shapes, slowed down" + (
            ": identified over true" if motion is not None else ""
        )
        left.append(_solid("modes", title, eye, target))
    recordings = [_signals(result, number) for number in range(len(result.recordings))]
    middle = rrb.Tabs(*recordings) if len(recordings) > 1 else recordings[0]
    table = rrb.TextDocumentView(origin="parameters", name="identified and true")
    upper = [charts[name] for name in ("responses", "stabilisation", "order") if name in charts]
    lower = [charts[name] for name in ("errors", "matrices") if name in charts]
    right = rrb.Vertical(rrb.Tabs(*upper), rrb.Tabs(*lower, table))
    columns = [*([rrb.Vertical(*left)] if left else []), middle, right]
    return rrb.Blueprint(
        rrb.Horizontal(*columns, column_shares=[3, 3, 4][-len(columns) :]),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
    )


def _places(result: Identification) -> tuple[str, ...]:
    shapes = mode_shapes(result.modal)
    return shapes[0].places if shapes else ()


def _before(motion: Motion | None, result: Identification) -> tuple[list[float], list[float]]:
    """Return eye and target that have the whole structure in view."""
    height = 0.3 * max(len(_places(result)) - 1, 1)
    if motion is not None:
        height = float(max(motion.model.stat.center[2] * 2, 0.2))
    wide = max(height, 0.4)
    return [0.75 * wide, -1.25 * wide, 0.7 * height], [0.0, 0.0, 0.47 * height]


def _solid(origin: str, name: str, eye: list[float], target: list[float]) -> rrb.View:
    return rrb.Spatial3DView(
        origin=origin, name=name, background=list(DARK), line_grid=rrb.LineGrid3D(visible=False),
        eye_controls=rrb.EyeControls3D(position=eye, look_target=target),
    )  # fmt: skip


def _signals(result: Identification, number: int) -> rrb.Container:
    """Return the views of one recording: every channel, and a row of what is left."""
    recording, root = result.recordings[number], f"recording{number + 1}"
    present = [name for name in result.inputs if name in recording.names]
    views = [
        rrb.TimeSeriesView(
            origin=f"{root}/signals/{name}", name=f"{name} [{figures.unit_of(name, [recording])}]",
            plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop),
        )
        for name in (*present, *result.outputs)
    ]  # fmt: skip
    left = rrb.TimeSeriesView(origin=f"{root}/residual", name="what is left of the outputs")
    return rrb.Vertical(*views, left, name=f"{number + 1}: {printable(recording.source)}")
