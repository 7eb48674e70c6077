"""How a structure moved in a recording, by estimate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """An estimate of how the structure moved in one recording: q and its rates, (samples, n)."""

    q: Array
    v: Array
    a: Array

    @classmethod
    def of(cls, q: Array, v: Array, step_s: float) -> Motion:
        """Return the motion whose acceleration follows from displacement and rate together.

        By 2 (q+ - 2 q + q-) / h^2 - (v+ - v-) / (2 h), compact differences of fourth order
        (Collatz 1960): 1 % off at five samples a period, where differences of v alone are 24 % off.
        """
        a = np.gradient(v, step_s, axis=0)
        bend = (q[2:] - 2 * q[1:-1] + q[:-2]) / step_s**2
        a[1:-1] = 2 * bend - a[1:-1]
        return cls(q, v, a)
