"""What an identification shows: responses, time histories, shapes, stabilisation, matrices."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.identification.result import Identification
from twin.modal import ModalModel, mac
from twin.view.colours import (
    FORCE,
    GROUND,
    IDENTIFIED,
    MEASURED,
    REJECTED,
    TRUE,
    measured_and_identified,
)
from twin.view.comparison import Row, place_of, same_rows
from twin.view.figures import SHOWN_SINGULAR_VALUES, responses, unit_of
from twin.view.page.blocks import Plot
from twin.view.page.plots import Panel, Trace, figure, line, points

Array = NDArray[np.float64]

RIGHT_ANGLES = [(v, f"{v}°") for v in (-180, -90, 0, 90, 180)]
SHOWN_S = 8.0
"""How much of a long recording is shown before one zooms out [s]."""

SCALE = [[0.0, "#2166ac"], [0.5, "#ffffff"], [1.0, "#b2182b"]]
"""Blue for negative, white for nothing, red for positive entries."""


def time_histories(result: Identification, index: int = 0) -> Plot:
    """Return inputs and outputs of a recording, measured beside re-simulated, and the residual."""
    recording, predicted = result.recordings[index], result.predicted[index]
    time = recording.time
    panels = [
        Panel(f"<b>{name}</b> [{unit_of(name, [recording])}]",
              [line(time, recording.column(name), "driving", FORCE)], share=0.7)
        for name in result.inputs
        if name in recording.names
    ]  # fmt: skip
    for column, name in enumerate(result.outputs):
        measured = recording.column(name)
        left = measured - predicted[:, column]
        rms = float(np.sqrt(np.mean(measured**2)))
        share = float(np.sqrt(np.mean(left**2))) / rms if rms else float("nan")
        panels.append(
            Panel(f"<b>{name}</b> [{unit_of(name, [recording])}]: error {100 * share:.2g} % of RMS",
                  [line(time, measured, "measured", MEASURED, 2.6),
                   line(time, predicted[:, column], "re-simulated", IDENTIFIED, 1.2),
                   line(time, left, "what is left", GROUND, 0.8)])
        )  # fmt: skip
    shown = (time[0], min(time[-1], time[0] + SHOWN_S))
    keys = [("driving", FORCE), ("measured", MEASURED), ("re-simulated", IDENTIFIED),
            ("what is left", GROUND)]  # fmt: skip
    caption = f"{recording.source}, {recording.duration_s:.3g} s; double-click for all of it."
    return Plot(figure(panels, "time [s]", shown, hover="x"), caption, keys, "time")


def frequency_responses(result: Identification) -> list[Plot]:
    """Return measured and identified responses to each input, magnitude, phase and coherence."""
    found = responses(result, 1500)
    freq, top = found.freq, found.top_hz
    at = found.measured.frequency_hz[found.shown]
    count = len(result.outputs)
    colours = [measured_and_identified(i, count) for i in range(count)]
    out = []
    for j, drive in enumerate(result.inputs):
        size: list[Trace] = []
        turn: list[Trace] = []
        for i, name in enumerate(result.outputs):
            dash, symbol = _style(i)
            H, G = found.measured.H[found.shown, i, j], found.H[:, i, j]
            seen, said = f"{name} measured", f"{name} identified"
            dots, curve = colours[i]
            size.append(points(at, np.abs(H), seen, dots, 4, symbol, 0.8))
            size.append(line(freq, np.abs(G), said, curve, 1.4, dash))
            turn.append(points(at, np.degrees(np.angle(H)), seen, dots, 3, symbol, 0.8))
            turn.append(line(freq, np.degrees(np.angle(G)), said, curve, 1.1, dash))
        above, below = (
            unit_of(result.outputs[0], result.recordings),
            unit_of(drive, result.recordings),
        )
        unit = f"({above})/({below})".replace("(N)", "N")
        panels = [
            Panel(f"magnitude [{unit}]", size, share=1.7, log=True),
            Panel("phase", turn, share=0.7, ticks=RIGHT_ANGLES, y_range=(-190, 190)),
        ]
        coherence = found.measured.coherence
        if coherence is not None:
            lines = [
                line(
                    at,
                    coherence[found.shown, i],
                    f"{name} measured",
                    colours[i][0],
                    1,
                    _style(i)[0],
                )
                for i, name in enumerate(result.outputs)
            ]
            panels.append(Panel("coherence", lines, share=0.5, y_range=(0, 1.05)))
        keys = [(trace["name"], trace["marker" if "marker" in trace else "line"]["color"])
                for trace in size]  # fmt: skip
        drawn = figure(panels, "frequency [Hz]", (0, top))
        signs = {
            f"{name} {what}": _SIGNS[i % 4][k]
            for i, name in enumerate(result.outputs)
            for k, what in enumerate(("measured", "identified"))
            if len(result.outputs) > 1
        }
        caption = f"Input {drive}: {found.measured.method}."
        out.append(Plot(drawn, caption, keys, "frequency", signs=signs))
    return out


_SIGNS = (("●", "──"), ("■", "╌╌"), ("▲", "┈┈"), ("✕", "─┈"))
"""What stands for an output's marker and dashes, as ``_style`` has them."""


def _style(number: int) -> tuple[str, str]:
    dashes, symbols = ("solid", "dash", "dot", "dashdot"), ("circle", "square", "triangle-up", "x")
    return dashes[number % 4], symbols[number % 4]


def shapes(modal: ModalModel) -> list[Plot]:
    """Return each mode's shape at the outputs, as signed lengths: real part, the largest one."""
    names = [str(name) for name in modal.outputs]
    out = []
    for r, (f, z) in enumerate(zip(modal.natural_freq, modal.damping_ratio, strict=True)):
        shape = modal.mode_shape[:, r]
        peak = shape[np.argmax(np.abs(shape))]
        value = np.real(shape / peak) if peak else np.zeros(len(shape))
        phase = np.degrees(np.angle(shape / peak)) if peak else np.zeros(len(shape))
        at = np.arange(len(names), dtype=float)
        stems: list[Trace] = [
            line(np.array([0.0, v]), np.array([y, y]), names[i], IDENTIFIED, 3)
            for i, (v, y) in enumerate(zip(value, at, strict=True))
        ]
        texts = [
            f"{n}: {v:+.3f}, phase {p:+.1f}°" for n, v, p in zip(names, value, phase, strict=True)
        ]
        stems.append(points(value, at, "shape", IDENTIFIED, 9, text=texts, hovertemplate="%{text}"))
        low, high = -0.5, len(names) - 0.5
        panel = Panel(f"<b>mode {r + 1}</b>: {f:.4g} Hz, {100 * z:.3g} % damping", stems,
                      share=0.35 + 0.16 * len(names), y_range=(low, high),
                      ticks=list(zip(at.tolist(), names, strict=True)))  # fmt: skip
        drawn = figure([panel], "", (-1.12, 1.12))
        out.append(Plot(drawn, "Scaled to its largest entry.", wide=False))
    return out


def parameter_errors(rows: Sequence[Row]) -> Plot:
    """Return (identified - true) / std of every parameter, and the Cramer-Rao bound over std."""
    known = [row for row in rows if row.error_in_std is not None]
    at = np.arange(len(known), dtype=float)[::-1]
    value = np.array([row.error_in_std for row in known], float)
    names = [row.quantity for row in known]
    bound = np.array([row.bound / row.std if row.bound and row.std else np.nan for row in known])
    traces = [
        {
            **line(np.array([-b, b]), np.array([y, y]), "Cramér-Rao bound", GROUND, 7),
            "opacity": 0.35,
        }
        for b, y in zip(bound, at, strict=True)
        if np.isfinite(b)
    ]
    spread = points(value, at, "error, ± one standard deviation", IDENTIFIED, 8)
    spread["error_x"] = {"type": "constant", "value": 1, "color": IDENTIFIED, "thickness": 1.4}
    edge = max(3.0, float(np.max(np.abs(value), initial=0.0)) + 1.4)
    panel = Panel("parameter", [*traces, spread], share=0.4 + 0.14 * len(known),
                  y_range=(-0.6, len(known) - 0.4),
                  ticks=list(zip(at.tolist(), names, strict=True)))  # fmt: skip
    drawn = figure([panel], "(identified - true) / standard deviation", (-edge, edge),
                   verticals=[(-2.0, GROUND), (0.0, TRUE), (2.0, GROUND)])  # fmt: skip
    keys = [("error, ± one standard deviation", IDENTIFIED)]
    if traces:
        keys.append(("Cramér-Rao bound", GROUND))
    return Plot(drawn, "Nineteen of twenty lie between the dotted lines where all is well.", keys)


def heat(values: Array, names: tuple[Sequence[str], Sequence[str]], title: str) -> Plot:
    """Return a matrix as colours with its entries as text."""
    rows, columns = names
    size = float(np.max(np.abs(values), initial=1e-30))
    trace = {
        "type": "heatmap", "z": values.tolist(), "x": list(columns), "y": list(rows),
        "colorscale": SCALE, "zmin": -size, "zmax": size, "showscale": False,
        "text": [[f"{v:.4g}" for v in row] for row in values], "texttemplate": "%{text}",
        "hovertemplate": "%{y}, %{x}: %{z:.6g}<extra></extra>", "xgap": 1, "ygap": 1,
    }  # fmt: skip
    drawn = figure([Panel(f"<b>{title}</b>", [trace], share=0.4 + 0.25 * len(rows))], "",
                   type="category", showgrid=False)  # fmt: skip
    drawn["layout"]["yaxis"] |= {"type": "category", "autorange": "reversed", "showgrid": False}
    return Plot(drawn, "", wide=False)


def matrices(result: Identification, truth: ModalModel | None) -> list[Plot]:
    """Return M, K, R and the MAC against the truth, or of the modes with themselves."""
    out = []
    model = result.second_order
    if model is not None:
        names = [place_of(name) for name in model.coordinates]
        for letter, unit in (("M", "kg"), ("K", "N/m"), ("R", "N s/m")):
            out.append(heat(getattr(model, letter), (names, names), f"{letter} [{unit}]"))
    shape = result.modal.mode_shape
    mine = [f"{f:.3g} Hz" for f in result.modal.natural_freq]
    rows = same_rows(result.modal, truth) if truth is not None else None
    if truth is not None and rows is not None and len(rows[0]) > 1:
        theirs = [f"true {f:.3g} Hz" for f in truth.natural_freq]
        values = mac(shape[rows[0]], truth.mode_shape[rows[1]])
        out.append(heat(values, (mine, theirs), "MAC with the truth"))
    elif len(shape) > 1:
        out.append(heat(mac(shape, shape), (mine, mine), "MAC of the modes with themselves"))
    return out


def singular_values(result: Identification) -> Plot:
    """Return the singular values of the Hankel matrix and the order that was chosen (Fig. 7)."""
    sigma = np.asarray(result.singular_values[:SHOWN_SINGULAR_VALUES])
    sigma = np.maximum(sigma, sigma[0] * 1e-17)
    number = np.arange(1.0, len(sigma) + 1)
    kept = number <= result.order
    traces = [
        points(number[kept], sigma[kept], "kept", IDENTIFIED, 8),
        points(number[~kept], sigma[~kept], "left out", REJECTED, 8),
    ]
    drawn = figure([Panel("singular value", traces, share=1.3, log=True)], "number")
    keys = [("kept", IDENTIFIED), ("left out", REJECTED)]
    return Plot(drawn, f"Order {result.order}.", keys)
