"""Plots as plotly takes them: panels above one another with one x axis, as plain dictionaries."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Trace = dict[str, Any]

MOST_POINTS = 4000
"""Points of a line that are drawn: the smallest and the largest of each bin beyond that."""

SMOOTH = 500
"""Points of a curve that are all drawn, so that it shows no corners of its own."""

DIGITS, X_DIGITS = 5, 8
"""Significant digits of what is drawn, and of where: times grow long."""

ROW_PX, TOP_PX, BARE_TOP_PX, BOTTOM_PX, GAP_PX = 150, 50, 30, 48, 34
"""Heights of a row of share one, above it (buttons, and a title below them), below, between."""

INK, GRID = "#1d2733", "#e3e8ed"
FONT = {"family": "system-ui, sans-serif", "size": 12, "color": INK}


@dataclass(frozen=True)
class Panel:
    """Traces over one x axis with a y axis of their own.

    Attributes:
        title: what the y axis is, with its unit; stands above it, so that nothing is cut off.
        traces: as ``line``, ``points``, ``band`` and ``bars`` make them.
        share: of the height, one for a row of usual height.
        log: whether the y axis is logarithmic.
        y_range: its ends; fitted to what is drawn without (of a log axis: the exponents).
        ticks: (value, text) of its ticks; plotly's choice without.
        text: (x, y, text) of texts in it.
    """

    title: str
    traces: Sequence[Trace]
    share: float = 1.0
    log: bool = False
    y_range: tuple[float, float] | None = None
    ticks: Sequence[tuple[float, str]] = ()
    text: Sequence[tuple[float, float, str]] = field(default=())


def figure(
    panels: Sequence[Panel],
    x_title: str,
    x_range: tuple[float, float] | None = None,
    x_log: bool = False,
    hover: str = "closest",
    verticals: Sequence[tuple[float, str]] = (),
    **x_axis: Any,
) -> dict[str, Any]:
    """Return panels one above the other, which zoom along x together.

    Args:
        panels: from the top.
        x_title: of the axis below the last.
        x_range: what is shown first (of a log axis: the exponents); everything without.
        x_log: whether it is logarithmic.
        hover: plotly's hovermode.
        verticals: (x, colour) of lines through all panels.
        x_axis: further settings of the x axis.
    """
    shares = [panel.share for panel in panels]
    top_px = TOP_PX if panels[0].title else BARE_TOP_PX
    plot_px = ROW_PX * sum(shares) + GAP_PX * (len(panels) - 1)
    layout: dict[str, Any] = {
        "height": round(plot_px + top_px + BOTTOM_PX),
        "margin": {"l": 52, "r": 14, "t": top_px, "b": BOTTOM_PX},
        "font": FONT,
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        "showlegend": False,
        "hovermode": hover,
        "dragmode": "zoom",
        "barmode": "group",
        "annotations": [],
        "shapes": [
            {"type": "line", "xref": "x", "yref": "paper", "x0": x, "x1": x, "y0": 0, "y1": 1,
             "layer": "below", "line": {"color": colour, "width": 1, "dash": "dot"}}
            for x, colour in verticals
        ],
    }  # fmt: skip
    data: list[Trace] = []
    top = plot_px
    for number, panel in enumerate(panels, start=1):
        name = "" if number == 1 else str(number)
        bottom = top - ROW_PX * panel.share
        axis: dict[str, Any] = {
            "domain": [max(bottom / plot_px, 0.0), min(top / plot_px, 1.0)],
            "type": "log" if panel.log else "linear",
            "anchor": "x",
            "gridcolor": GRID,
            "zerolinecolor": GRID,
            "automargin": True,
            "exponentformat": "power",
        }
        if panel.log:
            axis |= {"dtick": 1, "tickformat": "~g"}
        if panel.y_range:
            axis["range"] = list(panel.y_range)
        if panel.ticks:
            axis |= {
                "tickvals": [v for v, _ in panel.ticks],
                "ticktext": [t for _, t in panel.ticks],
            }
            axis.pop("dtick", None)
        layout[f"yaxis{name}"] = axis
        layout["annotations"].append(
            {"text": panel.title, "showarrow": False, "xref": "paper", "yref": f"y{name} domain",
             "x": 0, "y": 1, "xanchor": "left", "yanchor": "bottom", "font": {"size": 12}}
        )  # fmt: skip
        layout["annotations"] += [
            {"text": text, "showarrow": False, "xref": "x", "yref": f"y{name}", "x": x, "y": y,
             "xanchor": "left", "xshift": 4, "font": {"size": 11}}
            for x, y, text in panel.text
        ]  # fmt: skip
        data += [{**trace, "yaxis": f"y{name}", "xaxis": "x"} for trace in panel.traces]
        top = bottom - GAP_PX
    last = "" if len(panels) == 1 else str(len(panels))
    layout["xaxis"] = {
        "title": {"text": x_title, "standoff": 6},
        "anchor": f"y{last}",
        "type": "log" if x_log else "linear",
        "gridcolor": GRID,
        "zerolinecolor": GRID,
        "automargin": True,
        **({"range": list(x_range)} if x_range else {}),
        **x_axis,
    }
    return {"data": data, "layout": layout}


def line(
    x: Array, y: Array, name: str, colour: str, width: float = 1.4, dash: str = "solid"
) -> Trace:
    """Return a line; of a long one the smallest and largest values of each bin."""
    x, y = thinned(np.asarray(x, float), np.asarray(y, float))
    style = {"color": colour, "width": width, "dash": dash, "simplify": len(x) > SMOOTH}
    return _traced(x, y, name, "lines", line=style)


def points(
    x: Array, y: Array, name: str, colour: str, size: float = 4, symbol: str = "circle",
    opacity: float = 1.0, **more: Any,
) -> Trace:  # fmt: skip
    """Return markers."""
    every = max(1, -(-len(x) // MOST_POINTS))
    marker = {"color": colour, "size": size, "symbol": symbol}
    return _traced(x[::every], y[::every], name, "markers", marker=marker, opacity=opacity, **more)


def band(x: Array, low: Array, high: Array, name: str, colour: str) -> Trace:
    """Return the area between two curves, translucent."""
    around = np.concatenate([x, x[::-1]]), np.concatenate([high, low[::-1]])
    return _traced(
        *around, name, "lines", fill="toself", fillcolor=translucent(colour, 0.25),
        line={"width": 0}, hoverinfo="skip",
    )  # fmt: skip


def bars(
    values: Sequence[float], at: Sequence[str], name: str, colour: str, labels: Sequence[str]
) -> Trace:
    """Return upright bars with their values in words on top."""
    return {
        "type": "bar", "y": numbers(np.asarray(values, float)), "x": list(at), "name": name,
        "marker": {"color": colour}, "text": list(labels), "textposition": "outside",
        "cliponaxis": False, "hovertemplate": "%{text}",
    }  # fmt: skip


def ranked(
    labels: Sequence[str], values: Sequence[float], colours: Sequence[str], x_title: str
) -> dict[str, Any]:
    """Return horizontal bars in their order, each under its label, so that none is cut off."""
    at = [-i for i in range(len(values))]
    trace = {
        "type": "bar", "orientation": "h", "x": numbers(np.asarray(values, float)), "y": at,
        "marker": {"color": list(colours)}, "text": list(labels), "textposition": "none",
        "hovertemplate": "%{text}<extra></extra>",
    }  # fmt: skip
    drawn = figure(
        [Panel("", [trace], share=0.1 + 0.28 * len(values))], x_title, rangemode="tozero"
    )
    drawn["layout"]["yaxis"] |= {
        "showticklabels": False, "showgrid": False, "zeroline": False,
        "range": [at[-1] - 0.45 if at else -0.5, 0.85],
    }  # fmt: skip
    drawn["layout"]["xaxis"]["nticks"] = 5
    drawn["layout"]["margin"]["l"] = 12
    drawn["layout"]["bargap"] = 0.6
    drawn["layout"]["annotations"] += [
        {"text": label, "x": 0, "xref": "x domain", "y": y + 0.2, "yref": "y", "showarrow": False,
         "xanchor": "left", "yanchor": "bottom", "font": {"size": 12}}
        for label, y in zip(labels, at, strict=True)
    ]  # fmt: skip
    return drawn


def _traced(x: Array, y: Array, name: str, mode: str, **more: Any) -> Trace:
    step = np.diff(x)
    if len(x) > 2 and step[0] > 0 and np.allclose(step, step[0], rtol=1e-6):
        where: Trace = {"x0": float(x[0]), "dx": float((x[-1] - x[0]) / (len(x) - 1))}
    else:
        where = {"x": numbers(x, X_DIGITS)}
    return {"type": "scatter", "mode": mode, **where, "y": numbers(y), "name": name, **more}


def thinned(x: Array, y: Array, most: int = MOST_POINTS) -> tuple[Array, Array]:
    """Return a line of at most so many points: the extremes of each bin, in their order."""
    if len(x) <= most:
        return x, y
    bins = most // 2
    size = -(-len(x) // bins)
    kept: list[int] = []
    for start in range(0, len(x), size):
        part = np.nan_to_num(y[start : start + size])
        kept += sorted({start + int(np.argmin(part)), start + int(np.argmax(part))})
    return x[kept], y[kept]


def numbers(values: Array, digits: int = DIGITS) -> list[float | None]:
    """Return numbers with the digits that a picture shows; what is not finite is a gap."""
    flat = np.asarray(values, float).tolist()
    return [float(f"{v:.{digits}g}") if np.isfinite(v) else None for v in flat]


def translucent(colour: str, share: float) -> str:
    """Return "#D55E00" as "rgba(213,94,0,0.25)"."""
    r, g, b = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return f"rgba({r},{g},{b},{share:g})"
