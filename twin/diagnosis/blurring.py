"""What an analyser's filter does to the jumps of a force."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.signal import firwin, oaconvolve

Array = NDArray[np.float64]

CUT_OFF = 2 / 2.56
"""Edge of the flat band of an analyser over half its sampling rate: the customary 2.56 samples a
period of the highest frequency analysed."""

TAPS = 33
"""Length of the filter: a transition of 8 dB a tenth of the band, as analysers have."""

REACH = 5
"""Samples over which the difference's envelope is taken: a period of the filter's ringing."""


def smear(forces: Array) -> Array:
    """Return the envelope of what forces lose by an analyser's low-pass, (samples, l)."""
    if len(forces) <= TAPS:
        return np.zeros_like(forces)
    kernel = firwin(TAPS, CUT_OFF)
    half = TAPS // 2
    padded = np.pad(forces, ((half, half), (0, 0)), mode="edge")
    low = oaconvolve(padded, kernel[:, None], mode="valid", axes=0)
    return np.asarray(maximum_filter1d(np.abs(forces - low), REACH, axis=0))
