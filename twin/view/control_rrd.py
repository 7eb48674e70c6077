"""One Rerun recording of a controlled run: the true plant and what the controller believes."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from twin.control.absorber import DesignModel
from twin.control.controller import Controller
from twin.control.loop import steady_vibration
from twin.control.outcome import Outcome
from twin.control.plant import Plant
from twin.files import write_whole
from twin.model import Motion
from twin.view.chart import Chart
from twin.view.colours import FORCE, GROUND, IDENTIFIED, MEASURED, TRUE
from twin.view.comparison import Row
from twin.view.deflection import HEIGHT, beam
from twin.view.rrd import APPLICATION
from twin.view.rrd_charts import GAP, LEAST_DECADES, flat
from twin.view.scene import BEAM_COLOUR, TIMELINE, log_motion
from twin.view.signals import log_line
from twin.view.tables import REDUCTIONS, markdown_table

Array = NDArray[np.float64]

LINES = 800
"""Frequencies of the responses."""

RESPONSE_TALL = 55.0
"""Height of a floor's response in the viewer's units."""

CONTROLLED = ("without_control", "with_control")

PENDULUM_LENGTH = 0.165
LARGEST_SAMPLES = 20_000
NEGLIGIBLE = 1e-9
"""True entries smaller than this are structural zeros: an error in per cent means nothing."""


def write_control_rrd(
    path: Path,
    outcome: Outcome,
    plant: Plant,
    controller: Controller,
    believed: DesignModel,
    recording_id: str = "control",
) -> Path:
    """Write the run whole or not at all.

    Args:
        path: the .rrd file.
        outcome: the run.
        plant: the truth.
        controller: what closed the loop.
        believed: the model it was designed on.
        recording_id: the same id and the same data give the same recording.
    """
    return write_whole(
        path, lambda part: _write(part, outcome, plant, controller, believed, recording_id)
    )


def _write(
    path: Path,
    outcome: Outcome,
    plant: Plant,
    controller: Controller,
    believed: DesignModel,
    recording_id: str,
) -> None:
    stream = rr.RecordingStream(APPLICATION, recording_id=recording_id, send_properties=False)
    stream.save(str(path), default_blueprint=blueprint(outcome))
    log_control(stream, outcome, plant, controller, believed)
    stream.flush()
    stream.disconnect()


def log_control(
    stream: rr.RecordingStream,
    outcome: Outcome,
    plant: Plant,
    controller: Controller,
    believed: DesignModel,
) -> None:
    """Log a run of the closed loop to a file's or a viewer's stream; arguments as above."""
    motion = Motion(outcome.rate_hz, {}, outcome.qpos, plant.compile())
    log_motion(stream, "plant/frame", motion)
    _log_believed_frame(stream, outcome)
    _log_signals(stream, outcome)
    _log_responses(stream, controller, plant)
    stream.log(
        "parameters",
        rr.TextDocument(_summary(outcome, plant, believed), media_type="text/markdown"),
        static=True,
    )


def _log_responses(stream: rr.RecordingStream, controller: Controller, plant: Plant) -> None:
    """Draw each floor's steady vibration for a unit harmonic input, without and with control."""
    top = 0.5 / controller.dt
    freq = np.linspace(top / LINES, 0.98 * top, LINES)
    linear = plant.linear()
    free = steady_vibration(None, linear, freq, plant.delay, controller.dt)
    held = steady_vibration(controller, linear, freq, plant.delay)
    sizes = [1e3 * np.abs(response.displacement) for response in (free, held)]
    unit = "m/s²" if controller.known_input.startswith("acc") else "N"
    high = float(max(np.max(size) for size in sizes))
    count = sizes[0].shape[1]
    for floor in range(count):
        mine = np.concatenate([size[:, floor] for size in sizes])
        low = max(float(np.min(mine)), LEAST_DECADES * high)
        root, last = f"responses/floor{floor + 1}", floor == count - 1
        chart = Chart(stream, root, (0.0, top), (0.8 * low, 1.4 * high),
                      "frequency [Hz]" if last else "", f"floor{floor + 1} [mm per {unit}]",
                      y_log=True, at=(0.0, floor * (RESPONSE_TALL + GAP)),
                      tall=RESPONSE_TALL)  # fmt: skip
        chart.axes()
        for size, name, colour in zip(sizes, CONTROLLED, (GROUND, IDENTIFIED), strict=True):
            chart.line(name, freq, size[:, floor], colour)


def _log_signals(stream: rr.RecordingStream, outcome: Outcome) -> None:
    thin = max(len(outcome.angle) // LARGEST_SAMPLES, 1)
    fast = outcome.time[::thin]

    line = partial(log_line, stream)
    for column, floor in enumerate(outcome.floors):
        true = 1e3 * outcome.displacement[::thin, column]
        line(f"plant/displacement/{floor}", fast, true, f"{floor} true", TRUE)
        name = f"disp_{floor}"
        if name in outcome.estimates:
            guess = 1e3 * outcome.estimated[:, outcome.estimates.index(name)]
            place = f"believed/displacement/{floor}"
            line(place, outcome.sample_time, guess, f"{floor} estimated", IDENTIFIED)
    line("plant/torque", outcome.sample_time, outcome.torque, "torque", FORCE)
    line("plant/swing", fast, outcome.angle[::thin], "swing", MEASURED)
    line("plant/excitation", fast, outcome.excitation[::thin], outcome.known_input, GROUND)
    switched = (outcome.sample_time >= outcome.switch_s).astype(float)
    line("plant/control_on", outcome.sample_time, switched, "control on", TRUE)
    stream.set_time(TIMELINE, duration=0.0)
    stream.log("log", rr.TextLog("control off", level="INFO"))
    stream.set_time(TIMELINE, duration=outcome.switch_s)
    stream.log("log", rr.TextLog("control switched on", level="WARN"))
    stream.reset_time()


def _log_believed_frame(stream: rr.RecordingStream, outcome: Outcome) -> None:
    """Log the estimate as a frame of lines: what the controller believes, in its own tree."""
    levels = len(outcome.floors)
    x = np.zeros((len(outcome.sample_time), levels + 1))
    for level, floor in enumerate(outcome.floors, start=1):
        if f"disp_{floor}" in outcome.estimates:
            x[:, level] = outcome.estimated[:, outcome.estimates.index(f"disp_{floor}")]
    angle = np.zeros(len(x))
    if "angle_pendulum" in outcome.estimates:
        angle = outcome.estimated[:, outcome.estimates.index("angle_pendulum")]
    strips: list[Array] = []
    for row in range(len(x)):
        for level in range(levels):
            strips += [_in_space(beam(x[row, level], x[row, level + 1], level, s)) for s in (-1, 1)]
        for level in range(levels + 1):
            ends = np.array([[x[row, level] - 0.15, HEIGHT * level]] * 2)
            ends[1, 0] += 0.3
            strips.append(_in_space(ends))
        pivot = np.array([x[row, -1], HEIGHT * levels])
        tip = pivot + PENDULUM_LENGTH * np.array([np.sin(angle[row]), -np.cos(angle[row])])
        strips.append(_in_space(np.vstack([pivot, tip])))
    count = len(strips) // len(x)
    style = rr.LineStrips3D.from_fields(colors=[BEAM_COLOUR], radii=[0.004])
    stream.log("believed/frame", style, static=True)
    stream.send_columns(
        "believed/frame",
        [rr.TimeColumn(TIMELINE, duration=outcome.sample_time)],
        rr.LineStrips3D.columns(strips=strips).partition(np.full(len(x), count)),
    )


def _in_space(line: Array) -> Array:
    return np.column_stack([line[:, 0], np.zeros(len(line)), line[:, 1]])


def _summary(outcome: Outcome, plant: Plant, believed: DesignModel) -> str:
    """Return reductions, effort and believed against true matrices, as Markdown."""
    reduction = outcome.reduction
    lines = ["| reduction | " + " | ".join(outcome.floors) + " |"]
    lines.append("|---|" + "---:|" * len(outcome.floors))
    for window in ("whole", "steady", "rms"):
        shares = getattr(reduction, window)
        cells = " | ".join(f"{100 * shares[floor]:.1f} %" for floor in outcome.floors)
        lines.append(f"| {REDUCTIONS[window]} | {cells} |")
    effort = (
        f"Peak swing {outcome.peak_swing_rad:.3f} rad, peak torque "
        f"{outcome.peak_torque_nm:.3f} N m. Control is on from {outcome.switch_s:g} s."
    )
    parts = ["# Under control", "\n".join(lines), effort, "# Design model and true plant"]
    parts.append(markdown_table(_matrix_rows(believed, plant.linear())))
    return "\n\n".join([*parts, *(f"- {note}" for note in outcome.notes)])


def _matrix_rows(believed: DesignModel, true: DesignModel) -> Sequence[Row]:
    mine, theirs = believed.structure, true.structure
    shared = [name for name in theirs.coordinates if name in mine.coordinates]
    rows = []
    for letter, unit in (("M", "kg"), ("K", "N/m")):
        for a, first in enumerate(shared):
            for second in shared[a:]:
                value, truth = (
                    float(
                        getattr(m, letter)[m.coordinates.index(first), m.coordinates.index(second)]
                    )
                    for m in (mine, theirs)
                )
                if abs(truth) > NEGLIGIBLE:
                    rows.append(Row(f"{letter} {first} {second}", unit, value, true=truth))
    return rows


def blueprint(outcome: Outcome) -> rrb.Blueprint:
    """Return the arrangement of the views of a run."""
    levels = len(outcome.floors)
    dark = [18, 20, 24]

    def eye(distance: float) -> rrb.EyeControls3D:
        return rrb.EyeControls3D(
            position=[0.4, -0.45 - distance * levels, 0.24 * levels],
            look_target=[0, 0, 0.14 * levels],
        )

    frames = rrb.Horizontal(
        rrb.Spatial3DView(
            origin="plant/frame", name="True plant in MuJoCo", background=dark,
            line_grid=rrb.LineGrid3D(visible=False), eye_controls=eye(0.26),
        ),
        rrb.Spatial3DView(
            origin="believed/frame", name="What the controller estimates", background=dark,
            line_grid=rrb.LineGrid3D(visible=False), eye_controls=eye(0.3),
        ),
    )  # fmt: skip
    # left alone the viewer keeps the cursor in the middle, and at the end half a plot is empty
    whole = rrb.TimeAxis(
        view_range=rr.TimeRange(
            start=rr.TimeRangeBoundary.absolute(seconds=0.0),
            end=rr.TimeRangeBoundary.absolute(seconds=float(outcome.sample_time[-1])),
        )
    )
    floors = [
        rrb.TimeSeriesView(
            name=f"{floor} [mm]",
            axis_x=whole,
            contents=[f"plant/displacement/{floor}", f"believed/displacement/{floor}"],
        )
        for floor in outcome.floors
    ]
    unit = "m/s²" if outcome.known_input.startswith("acc") else "N"
    effort = [
        rrb.TimeSeriesView(origin="plant/torque", name="Torque [N m]", axis_x=whole),
        rrb.TimeSeriesView(origin="plant/swing", name="Swing [rad]", axis_x=whole),
        rrb.TimeSeriesView(origin="plant/excitation", name=f"Excitation [{unit}]", axis_x=whole),
    ]
    title = "steady vibration: grey without, orange with control"
    left = rrb.Vertical(
        frames,
        flat("responses", title, levels * (RESPONSE_TALL + GAP) - GAP),
        row_shares=[3, 2],
    )
    right = rrb.Vertical(
        rrb.TextDocumentView(origin="parameters", name="Result"),
        rrb.TextLogView(origin="log", name="Events"),
        row_shares=[4, 1],
    )
    return rrb.Blueprint(
        rrb.Horizontal(left, rrb.Vertical(*floors, *effort), right, column_shares=[4, 4, 2.6]),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
    )
