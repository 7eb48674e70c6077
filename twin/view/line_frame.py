"""A frame as lines in Rerun: what is known of it are the displacements of its floors alone."""

from __future__ import annotations

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twin.view.colours import rgb
from twin.view.deflection import HALF_SPAN, HEIGHT, ModeShape, beam
from twin.view.scene import DISPLAY_HZ, TIMELINE

Array = NDArray[np.float64]

LONGEST_MODE_S = 60.0
"""Beyond this the mode shapes stand still: they repeat, and a record may last for hours [s]."""

MODE_HZ = 0.5
MODE_AMPLITUDE = 0.08
MODE_SPACING = 0.55
"""Between the mode shapes, which stand side by side [m]."""


def log_line_frame(
    stream: rr.RecordingStream,
    root: str,
    time: Array,
    x: Array,
    colour: str,
    offset: float = 0.0,
    radius: float = 0.004,
    heights: Array | None = None,
    depth: float = 0.0,
    times: rr.TimeColumn | None = None,
) -> None:
    """Log floors and beams that follow displacements.

    Args:
        stream: the Rerun recording.
        root: entity path.
        time: [s], (frames,).
        x: displacement of ground and floors [m], (frames, levels).
        colour: of the lines.
        offset: of the whole frame along x [m].
        radius: of the lines [m].
        heights: of ground and floors [m], (levels,); evenly spaced without.
        depth: where along y it stands [m], so that of two frames one is in front.
        times: another timeline's, instead of ``time``.
    """
    z = HEIGHT * np.arange(x.shape[1]) if heights is None else heights
    strips: list[Array] = []
    for row in x:
        for level in range(len(row) - 1):
            for side in (-1, 1):
                path = beam(row[level], row[level + 1], level, side)
                up = path[:, 1] / HEIGHT - level
                path[:, 1] = z[level] + up * (z[level + 1] - z[level])
                strips.append(_in_space(path, offset, depth))
        for level, value in enumerate(row):
            ends = [[value + side * HALF_SPAN, z[level]] for side in (-1, 1)]
            strips.append(_in_space(np.array(ends), offset, depth))
    style = rr.LineStrips3D.from_fields(colors=[rgb(colour)], radii=[radius])
    stream.log(root, style, static=True)
    stream.send_columns(
        root,
        [times or rr.TimeColumn(TIMELINE, duration=time)],
        rr.LineStrips3D.columns(strips=strips).partition(np.full(len(x), len(strips) // len(x))),
    )


def log_mode(
    stream: rr.RecordingStream,
    root: str,
    mode: ModeShape,
    number: int,
    seconds: float,
    colour: str,
    behind: bool = False,
    still: rr.TimeColumn | None = None,
) -> None:
    """Log one mode shape as a moving frame of lines, beside the others, in slow motion.

    What stands ``behind`` another is a little thicker, so that both are seen where they agree. All
    along the timeline ``still`` it stands farthest out.
    """
    time = np.arange(0, min(max(seconds, 1 / MODE_HZ), LONGEST_MODE_S), 1 / DISPLAY_HZ)
    turn = np.exp(2j * np.pi * MODE_HZ * time)
    x = MODE_AMPLITUDE * np.real(turn[:, None] * mode.shape)
    radius, depth = (0.007, 0.03) if behind else (0.0035, 0.0)
    offset = MODE_SPACING * number
    log_line_frame(stream, root, time, x, colour, offset, radius, depth=depth)
    if still is not None:
        out = np.repeat(x[:1], len(still.times), axis=0)
        log_line_frame(stream, root, time, out, colour, offset, radius, depth=depth, times=still)


def log_mode_label(stream: rr.RecordingStream, root: str, mode: ModeShape, number: int) -> None:
    """Log a mode's frequency and damping above it."""
    label = f"{mode.frequency_hz:.3f} Hz, {100 * mode.damping_ratio:.2f} %"
    top = HEIGHT * (len(mode.places) - 1) + 0.1
    stream.log(
        root,
        rr.Points3D([[MODE_SPACING * number, 0, top]], labels=[label], radii=[0.001],
                    show_labels=True),
        static=True,
    )  # fmt: skip


def _in_space(line: Array, offset: float, depth: float) -> Array:
    return np.column_stack([line[:, 0] + offset, np.full(len(line), depth), line[:, 1]])
