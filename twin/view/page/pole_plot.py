"""The stabilisation diagram as a plot that one can choose from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.identification.pole_diagram import PoleDiagram
from twin.view.colours import FRAME, IDENTIFIED
from twin.view.page.blocks import Plot
from twin.view.page.plots import Panel, figure, line, points
from twin.view.poles import kinds

Array = NDArray[np.float64]

SYMBOLS = {
    "x": "x-thin-open",
    "v": "triangle-down",
    "^": "triangle-up",
    "s": "square",
    "o": "circle",
    "d": "diamond-tall-open",
}
"""Plotly's names of matplotlib's markers."""

BEHIND = "y2"
"""The axis of the singular values, on the right."""


def pole_plot(
    diagram: PoleDiagram, modes: Sequence[float] | Array, top_hz: float, command: str = ""
) -> Plot:
    """Return poles of every order, coloured by what is stable, over the singular values.

    Args:
        diagram: what is drawn.
        modes: natural frequencies that a line marks [Hz].
        top_hz: end of the frequency axis [Hz].
        command: what made the result; clicked poles are appended to it for the next run.
    """
    found = kinds(diagram.poles, modes)
    traces = [
        points(freq, order, name, colour, 6, SYMBOLS[marker], 0.9)
        for name, colour, marker, freq, order in found
    ]
    lines = [(float(f), IDENTIFIED) for f in modes]
    panel = Panel("order of the model", traces, share=2.2)
    drawn = figure([panel], "natural frequency [Hz]", (0, top_hz), verticals=lines)
    names = f"singular values of the {diagram.of}"
    for number, curve in enumerate(diagram.curves.T):
        positive = np.where(curve > 0, curve, np.nan)
        width = 1.3 if not number else 0.7
        trace = line(diagram.frequency_hz, positive, names, FRAME, width)
        drawn["data"].insert(0, {**trace, "xaxis": "x", "yaxis": BEHIND, "hoverinfo": "skip"})
    # an axis over another takes over its ticks, orders such as 45.2, unless told not to
    drawn["layout"]["yaxis"] |= {"overlaying": BEHIND, "tickmode": "auto"}
    drawn["layout"]["yaxis2"] = {
        "type": "log", "side": "right", "showgrid": False, "automargin": True, "anchor": "x",
        "exponentformat": "power", "dtick": 1, "tickformat": "~g",
    }  # fmt: skip
    keys = [*((name, colour) for name, colour, *_ in found), (names, FRAME)]
    if len(lines):
        keys.append(("identified mode", IDENTIFIED))
    caption = (
        "A mode is a column of poles that stays as the order grows; click poles to choose them."
    )
    return Plot(drawn, caption, keys, "frequency", pick=command or "twin identify ...")
