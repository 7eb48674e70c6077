"""The frequency response of an identified model."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.identification.modal_response import frequency_response
from twin.identification.result import Identification
from twin.identification.spectra import Spectrum

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def identified_response(result: Identification, frequency_hz: Array) -> ComplexArray:
    """Return the FRF of the fit, else of the realization, (frequencies, outputs, inputs)."""
    frequency_hz = np.asarray(frequency_hz, float)
    fit = result.fit
    if fit is None:
        return result.state_space.frequency_response(frequency_hz)
    none = np.zeros((len(frequency_hz), 0), complex)
    lines = Spectrum(2 * np.pi * frequency_hz, none, none, 1, 1 / result.sampling_hz)
    return frequency_response(fit.parameters, lines, fit.hold, fit.w_max)
