"""Which poles of a wide-band fit are modes to be listed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import special

from twin.identification.wide_band import WideFit

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
