"""Line plots over anything but time in Rerun: axes, ticks and curves as two-dimensional lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twin.view.colours import FRAME, GROUND, rgb

Array = NDArray[np.float64]

WIDE, TALL = 160.0, 90.0
"""Size of a chart in the viewer's units."""

TICK, HAIR, STROKE = 1.2, 0.12, 0.28
MOST_TICKS = 6

ABOVE = 40.0
"""Draw order above that of points, which is 30."""

CELL = 40
"""Edge of a matrix's cell in the viewer's units."""

EMPTY, POSITIVE, NEGATIVE = 35.0, (178.0, 24.0, 43.0), (33.0, 102.0, 172.0)
"""Colours of entries that are nothing, the largest, the smallest."""


@dataclass(frozen=True)
class Chart:
    """Axes that stand under an entity.

    Attributes:
        stream: of the recording.
        root: entity path.
        x: ends of the x axis.
        y: ends of the y axis.
        x_title: its name with unit.
        y_title: its name with unit.
        y_log: whether the y axis is logarithmic.
        at: where its upper left corner is: several charts stand under one root.
        tall: its height.
        y_ticks: of the y axis; round numbers without.
    """

    stream: rr.RecordingStream
    root: str
    x: tuple[float, float]
    y: tuple[float, float]
    x_title: str
    y_title: str
    y_log: bool = False
    at: tuple[float, float] = (0.0, 0.0)
    tall: float = TALL
    y_ticks: tuple[float, ...] | None = None

    def place(self, x: Array, y: Array) -> Array:
        """Return points of the chart in the viewer's units, (n, 2); outside ones on the edge."""
        low, high = self._scaled(np.array(self.y))
        across = (np.asarray(x, float) - self.x[0]) / (self.x[1] - self.x[0])
        up = (self._scaled(np.asarray(y, float)) - low) / (high - low)
        return np.column_stack(
            [self.at[0] + WIDE * across, self.at[1] + self.tall * (1 - np.clip(up, 0, 1))]
        )

    def _scaled(self, y: Array) -> Array:
        return np.log10(np.maximum(y, 1e-300)) if self.y_log else y

    def axes(self) -> None:
        """Log the frame, the ticks and the titles."""
        (left, top), (right, bottom) = self.at, (self.at[0] + WIDE, self.at[1] + self.tall)
        frame = [[left, top], [left, bottom], [right, bottom], [right, top], [left, top]]
        strips: list[Sequence[Sequence[float]]] = [frame]
        texts: list[tuple[tuple[float, float], str]] = []
        for value in _ticks(*self.x):
            x = self.place(np.array([value]), np.array([self.y[0]]))[0, 0]
            strips.append([[x, bottom], [x, bottom - TICK]])
            texts.append(((float(x), bottom + 3.5), f"{value:g}"))
        found = _decades(*self.y) if self.y_log else _ticks(*self.y)
        for value in found if self.y_ticks is None else self.y_ticks:
            y = self.place(np.array([self.x[0]]), np.array([value]))[0, 1]
            strips.append([[left, y], [left + TICK, y]])
            texts.append(((left - 7, float(y)), f"{value:g}"))
        texts.append(((left + WIDE / 2, bottom + 9), self.x_title))
        texts.append(((left + WIDE / 4, top - 5.5), self.y_title))
        grey, pale = rgb(GROUND), rgb(FRAME)
        lines = rr.LineStrips2D(strips, colors=[grey], radii=[HAIR])
        self.stream.log(f"{self.root}/axes", lines, static=True)
        labels = rr.Points2D(
            [place for place, _ in texts], labels=[text for _, text in texts], colors=[pale],
            radii=[0.01], show_labels=True,
        )  # fmt: skip
        self.stream.log(f"{self.root}/labels", labels, static=True)

    def line(
        self, name: str, x: Array, y: Array, colour: str, width: float = STROKE,
        above: bool = False,
    ) -> None:  # fmt: skip
        """Log a curve; ``above`` the points of the chart, or below them."""
        strip = rr.LineStrips2D(
            [self.place(x, y)], colors=[rgb(colour)], radii=[width],
            draw_order=ABOVE if above else None,
        )  # fmt: skip
        self.stream.log(f"{self.root}/{name}", strip, static=True)

    def points(self, name: str, x: Array, y: Array, colour: str, size: float = 0.5) -> None:
        """Log markers."""
        inside = np.isfinite(x) & np.isfinite(y)
        dots = rr.Points2D(self.place(x[inside], y[inside]), colors=[rgb(colour)], radii=[size])
        self.stream.log(f"{self.root}/{name}", dots, static=True)

    def text(self, name: str, x: Array, y: Array, texts: Sequence[str], colour: str) -> None:
        """Log labels."""
        words = rr.Points2D(
            self.place(x, y), labels=list(texts), colors=[rgb(colour)], radii=[0.01],
            show_labels=True,
        )  # fmt: skip
        self.stream.log(f"{self.root}/{name}", words, static=True)


def heat_map(
    stream: rr.RecordingStream,
    root: str,
    values: Array,
    names: tuple[Sequence[str], Sequence[str]],
    title: str,
) -> None:
    """Log a matrix as coloured cells with its entries, red for positive, blue for negative.

    Args:
        stream: of the recording.
        root: entity path; a view of its own shows it.
        values: (rows, columns).
        names: of rows and columns.
        title: stands above it.
    """
    rows, columns = values.shape
    size = float(np.max(np.abs(values), initial=1e-30))
    share = (np.abs(values) / size)[..., None]
    tint = np.where(values[..., None] > 0, POSITIVE, NEGATIVE)
    cells = np.round(EMPTY + share * (tint - EMPTY)).astype(np.uint8)
    stream.log(f"{root}/cells", rr.Image(np.kron(cells, np.ones((CELL, CELL, 1), np.uint8))),
               static=True)  # fmt: skip
    texts = [
        ((CELL * (j + 0.5), CELL * (i + 0.5)), f"{values[i, j]:.4g}")
        for i in range(rows)
        for j in range(columns)
    ]
    texts += [((-0.35 * CELL, CELL * (i + 0.5)), name) for i, name in enumerate(names[0])]
    texts += [((CELL * (j + 0.5), CELL * (rows + 0.2)), name) for j, name in enumerate(names[1])]
    texts.append(((CELL * columns / 2, -0.2 * CELL), title))
    labels = rr.Points2D(
        [place for place, _ in texts], labels=[text for _, text in texts],
        colors=[(230, 230, 230)], radii=[0.01], show_labels=True,
    )  # fmt: skip
    stream.log(f"{root}/labels", labels, static=True)


def _ticks(low: float, high: float) -> list[float]:
    """Return round numbers inside a range, at most ``MOST_TICKS``."""
    rough = (high - low) / (MOST_TICKS - 1)
    power = 10.0 ** np.floor(np.log10(rough))
    step = next(s * power for s in (1, 2, 5, 10) if s * power >= rough)
    first = np.ceil(low / step - 1e-9)
    return [float(step * k) + 0.0 for k in np.arange(first, np.floor(high / step + 1e-9) + 1)]


def _decades(low: float, high: float) -> list[float]:
    ends = range(int(np.ceil(np.log10(low))), int(np.floor(np.log10(high))) + 1)
    every = max(1, -(-len(ends) // MOST_TICKS))
    return [10.0**k for k in list(ends)[::every]]
