"""Sine sweeps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.errors import ExperimentError, available
from twin.laboratory.excitation import TimeBase, checked_band, positive

Array = NDArray[np.float64]

LAWS = ("linear", "logarithmic")


@dataclass(frozen=True)
class Sweep:
    """A sine whose frequency runs through a band once, from the record's first instant to its end.

    Attributes:
        rms_n: RMS of the force [N]; its amplitude is sqrt(2) times that.
        band_hz: first and last frequency [Hz]; a logarithmic sweep starts above zero.
        law: linear (equal time for each hertz) or logarithmic (equal time for each octave).

    Raises:
        ExperimentError: a value out of its range.
    """

    rms_n: float = 0.1
    band_hz: tuple[float, float] = (0.5, 12.0)
    law: str = "linear"

    kind = "sweep"
    moves_the_ground = False
    shortest_s = None

    def __post_init__(self) -> None:
        positive(self.rms_n, "the RMS level of a shaker", "newtons")
        checked_band(self.band_hz)
        if self.law not in LAWS:
            raise ExperimentError(f"no '{self.law}' sweep; there are {available(LAWS)}")
        if self.law == "logarithmic" and self.band_hz[0] == 0:
            raise ExperimentError("a logarithmic sweep cannot start at 0 Hz")

    def history(self, base: TimeBase, rng: np.random.Generator) -> Array:
        """Return the force [N], (base.samples,). A sweep uses no random numbers."""
        time = base.time
        inside = (time >= 0) & (time <= base.duration_s)
        low, high = self.band_hz
        # phi = -90 degrees: a sine, so that the force starts at zero
        sine = signal.chirp(time[inside], low, base.duration_s, high, self.law, phi=-90)
        force = np.zeros(base.samples)
        force[inside] = self.rms_n * math.sqrt(2) * sine
        return force
