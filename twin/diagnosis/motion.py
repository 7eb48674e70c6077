"""How a structure moved in a recording, by estimate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.estimation.passing import Run

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """An estimate of how the structure moved in one recording: q and its rates, (samples, n)."""

    q: Array
    v: Array
    a: Array

    def acceleration(self, step_s: float) -> Array:
        """Return the acceleration that displacement and rate have together, (samples, n).

        By 2 (q+ - 2 q + q-) / h^2 - (v+ - v-) / (2 h), compact differences of fourth order (Collatz
        1960): 1 % off at five samples a period, where differences of the rate alone are 24 % off.
        They amplify what an estimate of q has above the band, which is to be filtered.
        """
        a = np.gradient(self.v, step_s, axis=0)
        bend = (self.q[2:] - 2 * self.q[1:-1] + self.q[:-2]) / step_s**2
        a[1:-1] = 2 * bend - a[1:-1]
        return np.asarray(a)


def motion_of(run: Run, n: int, step_s: float) -> Motion:
    """Return the motion of the first n coordinates as a predictor's pass, corrected, has it.

    A simulation corrects nothing: its motion is its own.
    """
    q, v = run.moved(corrected(run))
    return Motion(q[:, :n], v[:, :n], np.gradient(v[:, :n], step_s, axis=0))


def corrected(run: Run) -> Array:
    """Return the states of a pass once each sample is read, (samples, states)."""
    gain = run.gains.state[np.minimum(np.arange(len(run.x)), len(run.gains.state) - 1)]
    return np.asarray(run.x + np.einsum("kij,kj->ki", gain, run.e))


def begun_with(run: Run) -> Array | None:
    """Return displacements, then rates, of the structure where laws began, (2 n,), if they did."""
    if run.averages.start is None:
        return None
    return np.concatenate([part[0] for part in run.moved(run.averages.start[None])])
