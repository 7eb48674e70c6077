"""What a linear structure answers along s.

    H(s) = (Cd + s Cv + s^2 Ca) (K + s R + s^2 M)^-1 B + Cu

Source: Ewins 2000, Modal Testing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.model.linear import LinearModel

Complex = NDArray[np.complex128]


def receptance(model: LinearModel, s: Complex) -> Complex:
    """Return q for unit forces on q at s [1/s], (frequencies, n, n) [m/N].

    A motion that nothing holds has none at s = 0: there it is left out.
    """
    at = s[:, None, None]
    dynamic = model.K + at * model.R + at**2 * model.M
    still = s == 0
    out = np.zeros(dynamic.shape, complex)
    out[~still] = np.linalg.inv(dynamic[~still])
    out[still] = np.linalg.pinv(model.K)
    return out


def transfer(model: LinearModel, s: Complex) -> Complex:
    """Return outputs for unit inputs at s [1/s], (frequencies, m, r)."""
    at = s[:, None, None]
    seen = model.Cd + at * model.Cv + at**2 * model.Ca
    return np.asarray(seen @ receptance(model, s) @ model.B + model.Cu)
