"""A slider in Rerun: a structure where it is farthest out, along a timeline of magnifications."""

from __future__ import annotations

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twin.model import Motion
from twin.view.magnified import moved, peak
from twin.view.scene import log_poses

Array = NDArray[np.float64]

SLIDER = "magnification"
"""The timeline, which the viewer offers beside that of time."""

FACTORS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000)
BEYOND = 3.0
"""How far the slider goes beyond the magnification that is shown over time."""

HINT = f"slider: {SLIDER}"
"""In the name of a view: which timeline to choose."""


def factors(shown: float) -> tuple[int, ...]:
    """Return the magnifications of the slider.

    Args:
        shown: the magnification of the motion over time.
    """
    return tuple(f for f in FACTORS if f <= max(BEYOND * shown, FACTORS[2]))


def marks(shown: float) -> rr.TimeColumn:
    """Return the slider's magnifications as the times of what is logged along it."""
    return rr.TimeColumn(SLIDER, sequence=factors(shown))


def log_slider(
    stream: rr.RecordingStream, root: str, motion: Motion, shown: float, at: int | None = None
) -> None:
    """Log a moment of a motion, ever more magnified; the geometry is logged with the motion.

    Args:
        stream: the Rerun recording.
        root: entity path of the motion.
        motion: not magnified.
        shown: the magnification of the motion over time.
        at: the sample; where the structure is farthest from its first pose without.
    """
    log_poses(stream, root, motion.model, slid(motion, shown, at), marks(shown))


def slid(motion: Motion, shown: float, at: int | None = None) -> Array:
    """Return the joint positions of a moment at every magnification, (factors, nq)."""
    row = peak(motion) if at is None else at
    rest, out = motion.qpos[0], motion.qpos[row]
    return np.array([moved(motion.model, rest, out, by) for by in factors(shown)])
