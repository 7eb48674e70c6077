"""Which fit to believe: starting points, inter-sample behaviour and number of modes compared."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twin.errors import IdentificationError
from twin.identification.maximum_likelihood import ModalFit, fit_modal
from twin.identification.modal_response import Hold
from twin.identification.records import Records
from twin.identification.spectra import Spectrum
from twin.identification.starts import Realizations, candidate_poles

HOLDS: tuple[Hold, ...] = ("band-limited", "held")
OUT_OF_BAND = 1.3
HEAVY = 0.5
"""A mode with more damping than this is a smooth background, not a resonance."""

DECISIVE = 20.0
"""Difference in BIC below which records do not tell how the input behaves between samples."""


def best_fits(
    records: Records, found: Realizations, band_hz: tuple[float, float] | None
) -> list[tuple[str, ModalFit]]:
    """Fit from every starting point and for either inter-sample behaviour.

    Returns:
        The best fit of each behaviour that the records allow, with the origin of its starting
        poles, the one to believe first in front: a clearly better one, else the band-limited
        input that an analyser with an anti-alias filter delivers.

    Raises:
        IdentificationError: no starting point leads to a fit.
    """
    best: list[tuple[str, ModalFit]] = []
    problem = "no oscillating pole was found"
    # The same samples are left free whatever the hold, so that likelihoods can be compared.
    spectra = records.spectra(band_hz, edges=True)
    top = max(float(s.omega[-1]) for s in spectra)
    for hold in HOLDS:
        fits = []
        for name, poles in candidate_poles(found):
            inside = poles[np.abs(poles) < OUT_OF_BAND * top]
            try:
                fits.append((name, fit_modal(spectra, inside, hold)))
            except IdentificationError as error:
                problem = str(error)
        if fits:
            best.append(min(fits, key=lambda named: named[1].bic))
    if not best:
        raise IdentificationError(f"the refinement found no model: {problem}")
    least = min(fit.bic for _, fit in best)
    return [(name, fit) for name, fit in best if fit.bic < least + DECISIVE]


def completed(
    fit: ModalFit, records: Records, band_hz: tuple[float, float] | None, prune: bool
) -> ModalFit:
    """Add the out-of-band term and drop modes where the evidence asks for it."""
    spectra = records.spectra(band_hz, edges=True)
    fuller = fit_modal(spectra, fit.parameters.poles, fit.hold, residual=True)
    fit = fuller if fuller.bic < fit.bic else fit
    fit = _without_needless_modes(fit, spectra) if prune else fit
    if fit.hold == "held" and any(s.edge for s in spectra):
        spectra = records.spectra(band_hz, edges=False)
        fit = fit_modal(spectra, fit.parameters.poles, fit.hold, fit.residual)
    return fit


def _without_needless_modes(fit: ModalFit, spectra: Sequence[Spectrum]) -> ModalFit:
    """Drop modes that no structure has, then every mode the data are better off without.

    A structure's modes lose energy, and one whose frequency is vague within its own bandwidth
    is a blur in the residual, not a resonance.
    """
    while len(fit.parameters.omega) > 1:
        p = fit.parameters
        _, damping_std = fit.modal_std(bound=True)
        top = max(float(s.omega[-1]) for s in spectra)
        impossible = (p.zeta <= 0) | (p.zeta > HEAVY) | (p.omega > top)
        suspect = int(np.argmax(np.where(impossible, np.inf, damping_std / np.abs(p.zeta))))
        smaller = fit_modal(spectra, np.delete(p.poles, suspect), fit.hold, fit.residual)
        if not impossible[suspect] and smaller.bic > fit.bic:
            break
        fit = smaller
    return fit
