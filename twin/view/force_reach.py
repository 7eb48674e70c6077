"""Which of the missing forces a picture shows first."""

from __future__ import annotations

import numpy as np

from twin.diagnosis.result import ForcePicture

RARE, ROOM = 0.002, 0.1
"""Share of the points at either end that stay outside; room around the rest."""


def force_reach(picture: ForcePicture) -> tuple[float, float] | None:
    """Return the forces that are shown first: all but the most extreme few, and the law."""
    if not np.any(np.isfinite(picture.latent)):
        return None
    low, high = np.nanquantile(picture.latent, [RARE, 1 - RARE])
    if picture.law is not None:
        low, high = min(low, np.nanmin(picture.law)), max(high, np.nanmax(picture.law))
    if picture.cycle is not None:
        low, high = min(low, picture.cycle[:, 1].min()), max(high, picture.cycle[:, 1].max())
    margin = ROOM * (high - low)
    return (float(low - margin), float(high + margin)) if high > low else None
