"""Charts of an identification in Rerun: responses, stabilisation, errors, matrices."""

from __future__ import annotations

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from twin.identification.at_sensors import modes_at_sensors
from twin.identification.result import Identification
from twin.modal import mac
from twin.model import Twin
from twin.view.chart import TALL, WIDE, Chart, heat_map
from twin.view.colours import (
    GROUND,
    IDENTIFIED,
    MEASURED,
    REJECTED,
    TRUE,
    measured_and_identified,
)
from twin.view.comparison import Row, matrices_of, matrix_rows, modal_rows, place_of, same_rows
from twin.view.figures import SHOWN_SINGULAR_VALUES, responses, unit_of
from twin.view.poles import of_modes

Array = NDArray[np.float64]

PHASE_TALL, GAP = 40.0, 18.0
"""Height of a phase below its magnitude, and the room between them."""

LEAST_DECADES = 1e-5
"""Smallest magnitude that is drawn, as a share of the largest."""

ROOM = 1.6
"""Where the names of the errors begin, as a share of the largest error that is drawn."""

BESIDE = 20.0
"""Room around a chart for its labels."""


def views(result: Identification, truth: Twin | None) -> dict[str, rrb.View | rrb.Container]:
    """Return the views of the charts that ``log`` writes, by what they show."""
    out: dict[str, rrb.View | rrb.Container] = {}
    tall = TALL + GAP + PHASE_TALL
    plots = [
        flat(f"responses/{name}", f"response to {name}: measured (points), identified", tall)
        for name in result.inputs
    ]
    out["responses"] = plots[0] if len(plots) == 1 else rrb.Tabs(*plots, name="responses")
    if result.diagram:
        out["stabilisation"] = flat(
            "stabilisation", "stabilisation: blue are a mode's (orange), grey are none's", TALL
        )
    if len(result.singular_values):
        out["order"] = flat("order", "singular values", TALL)
    if any(row.error_in_std is not None for row in _rows(result, truth)):
        out["errors"] = flat(
            "errors", "(identified - true) / std, its bars; grey: Cramér-Rao bound", TALL
        )
    names = _matrices(result, truth)
    if names:
        grid = [rrb.Spatial2DView(origin=f"matrices/{name}", name=name) for name in names]
        out["matrices"] = rrb.Grid(*grid, name="M, K, R and MAC")
    return out


def flat(origin: str, name: str, tall: float) -> rrb.View:
    """Return a view of charts that are ``tall`` together."""
    bounds = rrb.VisualBounds2D(
        x_range=[-BESIDE, WIDE + 0.5 * BESIDE], y_range=[-0.6 * BESIDE, tall + 0.9 * BESIDE]
    )
    return rrb.Spatial2DView(origin=origin, name=name, visual_bounds=bounds)


def log(stream: rr.RecordingStream, result: Identification, truth: Twin | None) -> None:
    """Log every chart."""
    _log_responses(stream, result)
    if result.diagram:
        _log_stabilisation(stream, result)
    if len(result.singular_values):
        _log_order(stream, result)
    rows = [row for row in _rows(result, truth) if row.error_in_std is not None]
    if rows:
        _log_errors(stream, rows)
    for name, (values, names, title) in _matrices(result, truth).items():
        heat_map(stream, f"matrices/{name}", values, names, title)


def _rows(result: Identification, truth: Twin | None) -> tuple[Row, ...]:
    if truth is None:
        return ()
    matrices = matrix_rows(result.second_order, matrices_of(truth), result.second_order_std)
    return (*modal_rows(result, modes_at_sensors(truth, result.outputs)), *matrices)


def _log_responses(stream: rr.RecordingStream, result: Identification) -> None:
    found = responses(result)
    at, freq = found.measured.frequency_hz[found.shown], found.freq
    ends = (0.0, float(found.top_hz))
    inside = at <= ends[1]
    for j, drive in enumerate(result.inputs):
        H, G = np.abs(found.measured.H[found.shown, :, j]), np.abs(found.H[:, :, j])
        high = float(max(np.max(H), np.max(G)))
        low = float(max(min(np.min(H[H > 0]), np.min(G[G > 0])), LEAST_DECADES * high))
        units = (unit_of(n, result.recordings) for n in (result.outputs[0], drive))
        unit = "({})/({})".format(*units).replace("(N)", "N")
        size = Chart(stream, f"responses/{drive}/magnitude", ends, (0.8 * low, 1.4 * high), "",
                     f"magnitude [{unit}]", y_log=True)  # fmt: skip
        turn = Chart(stream, f"responses/{drive}/phase", ends, (-190.0, 190.0), "frequency [Hz]",
                     "phase [°]", at=(0.0, TALL + GAP), tall=PHASE_TALL,
                     y_ticks=(-180.0, -90.0, 0.0, 90.0, 180.0))  # fmt: skip
        size.axes()
        turn.axes()
        for i, name in enumerate(result.outputs):
            seen = found.measured.H[found.shown, i, j]
            dots, curve = measured_and_identified(i, len(result.outputs))
            size.points(f"1_measured/{name}", at[inside], np.abs(seen)[inside], dots)
            size.line(f"2_identified/{name}", freq, G[:, i], curve, above=True)
            phase = np.degrees(np.angle(seen))[inside]
            turn.points(f"1_measured/{name}", at[inside], phase, dots, 0.4)
            turn.line(f"2_identified/{name}", freq, np.degrees(np.angle(found.H[:, i, j])), curve)


def _log_stabilisation(stream: rr.RecordingStream, result: Identification) -> None:
    lasting = np.array(of_modes(result.diagram, result.modal.natural_freq), bool)
    freq = np.array([p.frequency_hz for p in result.diagram])
    order = np.array([p.order for p in result.diagram], float)
    top = result.fit.w_max / (2 * np.pi) if result.fit else result.sampling_hz / 2
    chart = Chart(stream, "stabilisation", (0.0, float(top)), (0.0, float(order.max() + 2)),
                  "natural frequency [Hz]",
                  "order of the model")  # fmt: skip
    chart.axes()
    shown = freq <= top
    for mode in result.modal.natural_freq:
        ends = np.array([0.0, chart.y[1]])
        chart.line(f"modes/{mode:.4g}_Hz", np.full(2, mode), ends, IDENTIFIED, 0.15)
    others, stays = shown & ~lasting, shown & lasting
    chart.points("others", freq[others], order[others], REJECTED, 0.5)
    chart.points("stays", freq[stays], order[stays], MEASURED, 0.8)


def _log_order(stream: rr.RecordingStream, result: Identification) -> None:
    sigma = np.asarray(result.singular_values[:SHOWN_SINGULAR_VALUES])
    sigma = np.maximum(sigma, sigma[0] * 1e-17)
    number = np.arange(1.0, len(sigma) + 1)
    chart = Chart(stream, "order", (0.0, len(sigma) + 1.0), (0.7 * sigma.min(), 1.5 * sigma.max()),
                  "number", f"singular value of the Hankel matrix; order {result.order}",
                  y_log=True)  # fmt: skip
    chart.axes()
    kept = number <= result.order
    chart.points("kept", number[kept], sigma[kept], IDENTIFIED, 1.0)
    chart.points("left_out", number[~kept], sigma[~kept], REJECTED, 0.8)


def _log_errors(stream: rr.RecordingStream, rows: list[Row]) -> None:
    """Log (identified - true) / std as points with bars of one deviation, and the bound."""
    value = np.array([row.error_in_std for row in rows], float)
    edge = max(3.0, float(np.max(np.abs(value))) + 1.3)
    count = len(rows)
    chart = Chart(stream, "errors", (-ROOM * edge, edge), (0.0, count + 1.0),
                  "error / standard deviation", "± one deviation",
                  y_ticks=())  # fmt: skip
    chart.axes()
    for x, colour in ((-2.0, GROUND), (0.0, TRUE), (2.0, GROUND)):
        chart.line(f"limits/{x:g}", np.full(2, x), np.array([0.0, count + 1.0]), colour, 0.12)
    at = np.arange(count, 0, -1.0)
    for row, x, y in zip(rows, value, at, strict=True):
        if row.bound and row.std:
            reach = row.bound / row.std
            chart.line(f"bound/{row.quantity.replace(' ', '_')}", np.array([-reach, reach]),
                       np.full(2, y), REJECTED, 0.9)  # fmt: skip
        chart.line(f"spread/{row.quantity.replace(' ', '_')}", np.array([x - 1, x + 1]),
                   np.full(2, y), IDENTIFIED, 0.25)  # fmt: skip
    chart.points("value", value, at, IDENTIFIED, 0.9)
    names = [row.quantity for row in rows]
    chart.text("names", np.full(count, -0.5 * (1 + ROOM) * edge), at + 0.4, names, IDENTIFIED)


Matrix = tuple[Array, tuple[list[str], list[str]], str]


def _matrices(result: Identification, truth: Twin | None) -> dict[str, Matrix]:
    """Return M, K, R and the MAC with the truth, or of the modes with themselves."""
    out: dict[str, Matrix] = {}
    model = result.second_order
    if model is not None:
        places = [place_of(name) for name in model.coordinates]
        for letter, unit in (("M", "kg"), ("K", "N/m"), ("R", "N s/m")):
            out[letter] = (getattr(model, letter), (places, places), f"{letter} [{unit}]")
    shape = result.modal.mode_shape
    mine = [f"{f:.3g} Hz" for f in result.modal.natural_freq]
    true_modes = truth.modes() if truth is not None else None
    rows = same_rows(result.modal, true_modes) if true_modes is not None else None
    if true_modes is not None and rows is not None and len(rows[0]) > 1:
        theirs = [f"true {f:.3g}" for f in true_modes.natural_freq]
        values = mac(shape[rows[0]], true_modes.mode_shape[rows[1]])
        out["MAC"] = (values, (mine, theirs), "MAC with the truth")
    elif len(shape) > 1 and len(mine):
        out["MAC"] = (mac(shape, shape), (mine, mine), "MAC of the modes with themselves")
    return out
