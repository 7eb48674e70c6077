"""The gains of several systems of one shape, for differences between neighbours."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.estimation.kalman import EquivalentLinear, gains
from twin.estimation.system import Noise, Sampled

Array = NDArray[np.float64]


def neighbouring_gains(
    systems: Sequence[tuple[Sampled, Noise]], count: int, equivalent: EquivalentLinear | None
) -> tuple[Array, Array]:
    """Return corrections of state and held disturbances, and the innovations' covariances.

    Args:
        systems: k sampled systems of one shape with their noise levels.
        count: samples before the stationary gain takes over.
        equivalent: what laws add to each of them, if there are laws.

    Returns:
        Corrections (count + 1, n + w, m, k) and covariances (count + 1, m, m, k), the last ones
        stationary.

    Raises:
        ValueError: a Riccati equation has no stationary solution.
    """
    found = [gains(plant, noise, count, equivalent) for plant, noise in systems]
    corrections = [np.concatenate([each.state, each.held], axis=1) for each in found]
    return np.stack(corrections, axis=-1), np.stack([g.innovation for g in found], axis=-1)
