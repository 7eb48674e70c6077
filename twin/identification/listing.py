"""Which poles of a wide-band fit are modes to be listed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import special

from twin.identification.wide_band import WideFit

FELT = "beyond the band are felt inside it, but not measured"
"""What is said of poles outside the analysed band."""

FALSE_MODES = 0.05
"""Probability that any pole of a list is there though its damping is none: the usual 95 %."""


def listed_modes(found: WideFit) -> NDArray[np.intp]:
    """Return the indices of the families that are modes, by frequency.

    Every pole that leaves its damping's confidence interval above zero is one. There are as many
    trials as poles, so each gets its share of the error probability (Bonferroni). Several poles of
    one shape stand for a response that no single pole explains, and are listed as one. What
    lies beyond the band's ends is felt, not measured. What was chosen by hand is listed.

    Args:
        found: the fit.
    """
    several = np.array([len(members) > 1 for members in found.families])
    limit = -float(special.ndtri(FALSE_MODES / max(len(found.zeta), 1)))
    inside = (found.omega >= found.fit.w_min) & (found.omega <= found.fit.w_max)
    index = np.flatnonzero(found.by_hand | inside & (several | (found.zeta > limit * found.std[1])))
    return index[np.argsort(found.omega[index])]


def not_listed(omega: NDArray[np.float64], why: str) -> str:
    """Say that poles are part of the model and not of the list.

    Args:
        omega: their natural angular frequencies [rad/s], (poles,).
        why: what keeps them away.
    """
    at = ", ".join(f"{f / (2 * np.pi):.5g}" for f in np.sort(omega))
    return f"poles at {at} Hz {why}: they are part of the model, not of the list"
