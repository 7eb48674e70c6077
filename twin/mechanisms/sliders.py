"""Elasto-plastic sliders in parallel that follow the curve of first loading of a Bouc-Wen law."""

from __future__ import annotations

import numpy as np
from scipy.integrate import quad

SHARP = 8.0
"""From this sharpness on a single slider will do."""

KNOTS = (0.3, 0.55, 0.75, 0.9, 0.975)
"""Shares of the yield force where the polygon meets the curve, before the plateau."""


def as_sliders(
    stiffness: float, yield_force: float, sharpness: float
) -> tuple[tuple[float, float], ...]:
    """Return (stiffness [N/m], yield force [N]) of each slider.

    The curve z(d) of first loading, dz/dd = stiffness (1 - (z/yield_force)^sharpness), becomes a
    polygon; each corner of it is a slider that yields there (Iwan 1966). Their yield forces add up
    to the law's.
    """
    if sharpness >= SHARP:
        return ((stiffness, yield_force),)
    share = np.array([0.0, *KNOTS, 1.0])
    drift = np.zeros(len(share))
    for k in range(1, len(share) - 1):
        drift[k] = drift[k - 1] + quad(lambda z: 1 / (1 - z**sharpness), share[k - 1], share[k])[0]
    last = 1 - share[-2] ** sharpness
    drift[-1] = drift[-2] + 2 * (share[-1] - share[-2]) / last
    slope = np.append(np.diff(share) / np.diff(drift), 0.0)
    stiffnesses = stiffness * (slope[:-1] - slope[1:])
    yields = stiffnesses * drift[1:] * yield_force / stiffness
    return tuple((float(k), float(z)) for k, z in zip(stiffnesses, yields, strict=True))
