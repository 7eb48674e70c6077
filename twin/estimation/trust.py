"""How far a predictor believes outputs that are more uncertain than their noise.

Where they are, by variances B, the innovations' covariance S is S + B there, and the predictor
corrects by S (S + B)^-1 e.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twin.estimation.kalman import Gains

if TYPE_CHECKING:
    from twin.estimation.sensitivities import Slopes

Array = NDArray[np.float64]

BESIDE_NOISE = 1e-3
"""Share of an innovation's variance that changes nothing beside it: 0.05 % of its weight."""


def trust_in(gain: Gains, blur: Array | None) -> Array:
    """Return S (S + B)^-1 of every sample, (samples, m, m); none where nothing is blurred."""
    if blur is None:
        return np.zeros((0, 0, 0))
    S = gain.innovation[np.minimum(np.arange(len(blur)), len(gain.innovation) - 1)]
    m = S.shape[1]
    trust = np.broadcast_to(np.eye(m), S.shape).copy()
    hit = np.flatnonzero(np.any(blur > BESIDE_NOISE * np.diagonal(S, axis1=1, axis2=2), axis=1))
    wide = S[hit].copy()
    wide[:, range(m), range(m)] += blur[hit]
    trust[hit] = np.linalg.solve(wide, S[hit]).swapaxes(1, 2)
    return trust


def doubt_of(gain: Gains, trust: Array, d: Slopes) -> Array:
    """Return what trust changes by, (t, m, m, p), as ``predict`` takes it; empty where nothing is.

    With c = S (S + B)^-1 e it is dc = (I - S (S + B)^-1) dS S^-1 c.
    """
    if not (trust.size and len(d.order)):
        return np.zeros((0, 0, 0, 0))
    dS = d.until(len(gain.innovation))[..., d.order]
    S = gain.innovation[[*range(len(dS) - 1), -1]]
    return np.ascontiguousarray(np.einsum("toip,tij->tojp", dS, np.linalg.inv(S)))
