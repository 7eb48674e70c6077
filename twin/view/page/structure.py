"""A model from the side as a plot: bodies, sensors, what drives it, and the located places lit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from twin.model import Twin
from twin.view.colours import FRAME, GROUND, LOCATED, MEASURED, TRUE
from twin.view.located import CORNERS, Region, corners, endless
from twin.view.page.plots import Panel, Trace, figure, numbers, points, translucent

Array = NDArray[np.float64]

OBLIQUE = np.array([[1.0, 0.0], [0.35, 0.22], [0.0, 1.0]])
"""Where unit steps along x, y, z go on the page: the cabinet projection, y away from the reader."""

FAINTEST, BRIGHTEST = 0.12, 0.6
"""How strongly places of no and of the whole share are lit."""


def sketch(
    twin: Twin,
    lit: Mapping[str, tuple[Region, float]],
    inputs: Iterable[str] = (),
    outputs: Iterable[str] = (),
    sites: Mapping[str, Region] | None = None,
) -> dict[str, object]:
    """Return the model at rest, projected.

    Args:
        twin: the model.
        lit: place -> what it consists of, and its share between 0 and 1.
        inputs: channels that drive, to mark.
        outputs: channels that respond.
        sites: where the channels are.
    """
    model = twin.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    far = sorted(range(model.ngeom), key=lambda g: -float(data.geom_xpos[g, 1]))
    traces: list[Trace] = []
    for place, (where, share) in lit.items():
        box = where.box(model, data)
        if box is None:
            continue
        seen = (box[0] + 1.06 * CORNERS * box[1]) @ OBLIQUE
        strength = FAINTEST + (BRIGHTEST - FAINTEST) * share
        traces.append(_outline(seen, f"{place}: {100 * share:.0f} %", LOCATED, strength, LOCATED))
    traces += _skins(model)
    for geom in far:
        if endless(model, geom) or model.geom_rgba[geom, 3] == 0:
            continue
        body = model.body(int(model.geom_bodyid[geom])).name or "body"
        traces.append(_outline(corners(model, data, geom) @ OBLIQUE, body, FRAME, 0.55, GROUND))
    for channels, name, colour, symbol in (
        (inputs, "driven", MEASURED, "triangle-right"),
        (outputs, "sensor", TRUE, "square"),
    ):
        at = _middles(model, data, channels, sites or {})
        if at:
            x, z = np.array([spot for _, spot in at]).T
            texts = [channel for channel, _ in at]
            traces.append(
                points(x, z, name, colour, 9, symbol, text=texts, hovertemplate="%{text}")
            )
    drawn = figure(
        [Panel("", traces, share=1.9)], "", showticklabels=False, showgrid=False, zeroline=False,
        ticks="",
    )  # fmt: skip
    drawn["layout"]["xaxis"]["constrain"] = "domain"
    drawn["layout"]["yaxis"] |= {
        "scaleanchor": "x", "showticklabels": False, "showgrid": False, "zeroline": False,
        "constrain": "domain",
    }  # fmt: skip
    return drawn


def _skins(model: mujoco.MjModel) -> list[Trace]:
    """Return the beams that are drawn as skins, as lines through their vertices' middles."""
    out = []
    for skin in range(model.nskin):
        first = model.skin_vertadr[skin]
        seen = model.skin_vert[first : first + model.skin_vertnum[skin]] @ OBLIQUE
        out.append(_outline(np.asarray(seen, float), "beam", FRAME, 0.55, GROUND))
    return out


def _outline(seen: Array, name: str, fill: str, opacity: float, edge: str) -> Trace:
    try:
        order = ConvexHull(seen).vertices
    except QhullError:  # seen edge-on it is a line
        order = np.array([int(np.argmin(seen.sum(axis=1))), int(np.argmax(seen.sum(axis=1)))])
    ring = seen[[*order, order[0]]]
    return {
        "type": "scatter", "mode": "lines", "x": numbers(ring[:, 0]), "y": numbers(ring[:, 1]),
        "fill": "toself", "fillcolor": translucent(fill, opacity), "hoveron": "fills",
        "line": {"color": edge, "width": 1}, "name": name, "hoverinfo": "name",
    }  # fmt: skip


def _middles(
    model: mujoco.MjModel, data: mujoco.MjData, channels: Iterable[str], sites: Mapping[str, Region]
) -> list[tuple[str, Array]]:
    out = []
    for channel in channels:
        box = sites[channel].box(model, data) if channel in sites else None
        if box is not None:
            out.append((channel, box[0] @ OBLIQUE))
    return out
