"""Signals in Rerun: one line each, over the recording's time."""

from __future__ import annotations

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twin.view.colours import rgb
from twin.view.scene import TIMELINE

Array = NDArray[np.float64]


def log_line(
    stream: rr.RecordingStream,
    name: str,
    time: Array,
    values: Array,
    label: str,
    colour: str,
    width: float = 1.5,
) -> None:
    """Log a signal (samples,) at times [s] (samples,) as a line in one of the house's colours."""
    # averaging, the default, would draw a hammer's peak too low
    style = rr.SeriesLines(
        colors=rgb(colour), names=label, widths=width, aggregation_policy="MinMax"
    )
    stream.log(name, style, static=True)
    stream.send_columns(
        name,
        [rr.TimeColumn(TIMELINE, duration=time)],
        rr.Scalars.columns(scalars=np.ascontiguousarray(values)),
    )
