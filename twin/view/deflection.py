"""The frame as lines: beams and floors for any set of floor displacements."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.modal import ModalModel
from twin.view.comparison import place_of

Array = NDArray[np.float64]

HEIGHT = 0.3
HALF_SPAN = 0.15
POINTS = 9


@dataclass(frozen=True)
class ModeShape:
    """One mode's shape on the places of a frame.

    Attributes:
        places: "ground" and floors, from below, (levels,).
        shape: complex displacement of each, the largest of size one, (levels,).
        frequency_hz: natural frequency [Hz].
        damping_ratio: damping ratio.
    """

    places: tuple[str, ...]
    shape: NDArray[np.complex128]
    frequency_hz: float
    damping_ratio: float


def mode_shapes(modal: ModalModel) -> list[ModeShape]:
    """Return the shapes on a frame; a ground that was not measured stands still."""
    places = [place_of(name) for name in modal.outputs]
    floors = sorted({p for p in places if p.startswith("floor")}, key=lambda p: int(p[5:]))
    levels = ("ground", *floors)
    shapes = []
    for r in range(len(modal.natural_freq)):
        values = np.zeros(len(levels), complex)
        for level, place in enumerate(levels):
            if place in places:
                values[level] = modal.mode_shape[places.index(place), r]
        peak = values[np.argmax(np.abs(values))]
        values = values / peak if peak else values
        shapes.append(
            ModeShape(levels, values, float(modal.natural_freq[r]), float(modal.damping_ratio[r]))
        )
    return shapes


def aligned(shape: ModeShape, other: ModeShape) -> ModeShape:
    """Return a shape turned in phase and size so that it lies on another as well as it can."""
    size = np.vdot(shape.shape, shape.shape)
    if len(shape.shape) != len(other.shape) or not abs(size):
        return shape
    return replace(shape, shape=shape.shape * (np.vdot(shape.shape, other.shape) / size))


def beam(lower: float, upper: float, level: int, side: float) -> Array:
    """Return the line of a clamped beam between two levels, x and z, (points, 2)."""
    s = np.linspace(0, 1, POINTS)
    # A beam whose ends stay parallel follows the cubic 3 s^2 - 2 s^3.
    x = lower + (upper - lower) * (3 * s**2 - 2 * s**3) + side * HALF_SPAN
    return np.column_stack([x, HEIGHT * (level + s)])
