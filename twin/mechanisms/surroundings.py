"""What is known at a place before a mechanism there is fitted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Surroundings:
    """What is known at a place before a mechanism there is fitted: scales for its first guesses.

    Attributes:
        stiffness: along the port [N/m], or a scale of it.
        damping: along the port, the equivalent dashpot [N s/m].
        mass: that moves with the port (at the base: of the base) [kg].
        mass_above: that the port carries [kg].
        height: of the port: what leans over it [m].
        drift: estimated motion of the port [m], (samples,).
        rate: its rate [m/s], (samples,).
        reading: for a channel, what it recorded, in its unit, (samples,).
        natural_frequencies: of the model [Hz].
        duration_s: of the longest recording [s].
        sampling_hz: of the recordings.
        peaks: frequencies at which what is unexplained stands out [Hz].

    At a port that turns, forces are torques, displacements angles and masses moments of inertia.
    """

    stiffness: float
    damping: float
    mass: float
    mass_above: float
    height: float
    drift: Array
    rate: Array
    reading: Array
    natural_frequencies: tuple[float, ...]
    duration_s: float
    sampling_hz: float
    peaks: tuple[float, ...] = ()
