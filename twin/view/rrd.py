"""One Rerun recording of an identification, with a blueprint that needs no arranging."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from matplotlib.figure import Figure

from twin.files import write_whole
from twin.identification.result import Identification
from twin.laboratory import Performance
from twin.model import Twin
from twin.view import figures
from twin.view.colours import FORCE, IDENTIFIED, MEASURED
from twin.view.comparison import matrix_rows, modal_rows
from twin.view.deflection import mode_shapes
from twin.view.scene import TIMELINE, log_mode, log_motion
from twin.view.signals import log_line
from twin.view.tables import BOUND_NOTE, markdown_table

APPLICATION = "frame-twin"
IMAGE_DPI = 150


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
    stream = rr.RecordingStream(APPLICATION, recording_id=recording_id, send_properties=False)
    stream.save(str(path), default_blueprint=_blueprint(result, performance is not None))
    if performance is not None:
        log_motion(stream, "frame", performance.motion, performance.start_s)
    seconds = result.recordings[0].duration_s
    for number, mode in enumerate(mode_shapes(result.modal)):
        log_mode(stream, f"modes/mode{number + 1}", mode, number, seconds)
    _log_signals(stream, result)
    for name, figure in (
        ("frf", figures.frequency_responses(result)),
        ("singular_values", figures.singular_values(result)),
        ("stabilisation", figures.stabilisation_diagram(result)),
    ):
        stream.log(f"figures/{name}", image(figure), static=True)
    stream.log(
        "parameters", rr.TextDocument(summary(result, truth), media_type="text/markdown"),
        static=True,
    )  # fmt: skip
    stream.flush()
    stream.disconnect()


def summary(result: Identification, truth: Twin | None) -> str:
    """Return identified against true parameters and the notes, as Markdown."""
    modal = modal_rows(result, truth.modes() if truth else None)
    matrices = matrix_rows(
        result.second_order, truth.second_order() if truth else None, result.second_order_std
    )
    parts = ["# Identified parameters", markdown_table(modal), markdown_table(matrices)]
    parts += [BOUND_NOTE, f"Estimate: {result.route}.", f"Error: {100 * result.nrmse:.2f} % of RMS"]
    parts += [f"- {note}" for note in result.notes]
    return "\n\n".join(part for part in parts if part)


def _log_signals(stream: rr.RecordingStream, result: Identification) -> None:
    recording, predicted = result.recordings[0], result.predicted[0]

    def line(name: str, values: np.ndarray, label: str, colour: str, width: float) -> None:
        log_line(stream, name, recording.time, values, label, colour, width)

    for name in result.inputs:
        if name in recording.names:
            line(f"signals/{name}/measured", recording.column(name), "measured", FORCE, 1.5)
    for column, name in enumerate(result.outputs):
        line(f"signals/{name}/measured", recording.column(name), "measured", MEASURED, 2.5)
        line(f"signals/{name}/resimulated", predicted[:, column], "re-simulated", IDENTIFIED, 1.2)


def image(figure: Figure) -> rr.EncodedImage:
    """Return a figure as a picture that Rerun shows."""
    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=IMAGE_DPI, format="png")
    return rr.EncodedImage(contents=buffer.getvalue(), media_type="image/png")


def _blueprint(result: Identification, moving: bool) -> rrb.Blueprint:
    present = [n for n in result.inputs if n in result.recordings[0].names]
    signals = [
        rrb.TimeSeriesView(
            origin=f"signals/{name}", name=f"{name} [{figures.unit_of(name, result.recordings)}]",
            plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop),
        )
        for name in (*present, *result.outputs)
    ]  # fmt: skip
    dark = [18, 20, 24]
    count = len(result.modal.natural_freq)
    levels = len(mode_shapes(result.modal)[0].places) if count else 1
    modes = rrb.Spatial3DView(
        origin="modes",
        name="Mode shapes, slowed down",
        background=dark,
        line_grid=rrb.LineGrid3D(visible=False),
        eye_controls=rrb.EyeControls3D(
            position=[0.3 * (count - 1), -0.55 - 0.3 * max(1.2 * count, levels), 0.15 * levels],
            look_target=[0.3 * (count - 1), 0, 0.15 * levels],
        ),
    )
    frame = rrb.Spatial3DView(
        origin="frame",
        name="Frame in MuJoCo",
        background=dark,
        line_grid=rrb.LineGrid3D(visible=False),
        eye_controls=rrb.EyeControls3D(
            position=[0.45, -0.45 - 0.2 * levels, 0.25 * levels],
            look_target=[-0.03, 0, 0.135 * levels],
        ),
    )
    left = rrb.Vertical(frame, modes, row_shares=[3, 2]) if moving else modes
    tabs = rrb.Tabs(
        rrb.Spatial2DView(origin="figures/frf", name="FRF, measured and identified"),
        rrb.Spatial2DView(origin="figures/singular_values", name="Singular values"),
        rrb.Spatial2DView(origin="figures/stabilisation", name="Stabilisation"),
    )
    right = rrb.Vertical(
        rrb.TextDocumentView(origin="parameters", name="Identified and true"), tabs
    )
    return rrb.Blueprint(
        rrb.Horizontal(left, rrb.Vertical(*signals), right, column_shares=[3, 3, 4]),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
    )
