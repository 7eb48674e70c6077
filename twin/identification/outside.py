"""A mode above the analysed band, felt inside it by its flank: part of the model, not of the list.

The quadratic out-of-band term is the first of a series in (w / w_k)^2, which converges slowly
where the mode's frequency w_k is near the band's end: what it leaves biases the modes inside. A
pole of its own is the sum of that series.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import optimize

from twin.errors import IdentificationError
from twin.estimation.noise import covariance, whitener
from twin.identification.additions import BEYOND, BROAD, FLANK
from twin.identification.maximum_likelihood import ModalFit, fit_modal
from twin.identification.modal_response import frequency_response
from twin.identification.normal_equations import equations
from twin.identification.spectra import Spectrum

FARTHEST = BEYOND**2.5
"""How far above the band such a pole is first tried, in units of the band's upper end: an
analyser's full band ends at half the sampling rate over 1.28. At 1.28^2.5 = 1.85 the second term
of the series, the first that the quadratic one lacks, is (w / w_k)^4 < 0.09; where what lies
farther pays all the same, the fit moves the pole out."""

PLACES = 4
"""Places at which the flank is tried first: its promise has one broad maximum."""

NEAR = 0.01
"""Share of the frequency to which the best place is sought: within a few per cent of it the fit
finds the pole, from 10 % beside it may end in the noise of the inputs instead."""


def with_pole_outside(fit: ModalFit, spectra: Sequence[Spectrum]) -> ModalFit:
    """Return the fit with one more pole above the band, or the same where that does not pay.

    Args:
        fit: of the modes inside the band.
        spectra: what it was fitted to.
    """
    pole = _asked_for(fit, spectra)
    if pole is None:
        return fit
    poles = np.append(fit.parameters.poles, pole)
    try:
        felt = fit_modal(spectra, poles, fit.hold, fit.residual, outside=1)
    except IdentificationError:  # too few data for one more mode, or it went astray
        return fit
    return felt if stays_outside(felt, spectra) and felt.bic < fit.bic else fit


def _asked_for(fit: ModalFit, spectra: Sequence[Spectrum]) -> complex | None:
    """Return the pole whose flank promises most, or None where that is less than its price."""
    end = min(FARTHEST, _limit(fit, spectra) / fit.w_max)
    if end <= 1:
        return None
    places = np.linspace(0, np.log(end), PLACES + 1)[1:] - np.log(end) / (2 * PLACES)

    def pole(place: float) -> complex:
        return complex(fit.w_max * np.exp(place) * (-FLANK + 1j))

    gains = [_promised(fit, pole(place), spectra) for place in places]
    if max(gains) < fit.price_of_mode:
        return None
    best, half = places[int(np.argmax(gains))], np.log(end) / PLACES
    found = optimize.minimize_scalar(
        lambda place: -_promised(fit, pole(place), spectra),
        bounds=(max(best - half, 0.0), min(best + half, np.log(end))),
        method="bounded",
        options={"xatol": NEAR},
    )
    return pole(float(found.x))


def stays_outside(fit: ModalFit, spectra: Sequence[Spectrum]) -> bool:
    """Whether what was started above the band is there still, and a resonance that loses energy."""
    p = fit.parameters
    omega, zeta = p.omega[fit.measured.stop :], p.zeta[fit.measured.stop :]
    sound = (omega > fit.w_max) & (omega < _limit(fit, spectra)) & (zeta > 0) & (zeta < BROAD)
    return bool(np.all(sound))


def _limit(fit: ModalFit, spectra: Sequence[Spectrum]) -> float:
    """Return below which frequency a pole is told from its alias [rad/s].

    Only the sampled pole e^{l dt} counts where the input is held: above half the sampling rate it
    is the same as one below.
    """
    return float(np.pi / spectra[0].dt) if fit.hold == "held" else np.inf


def _promised(fit: ModalFit, pole: complex, spectra: Sequence[Spectrum]) -> float:
    """Return by how much twice the log-likelihood rises with a pole's flank, to first order.

    The score test (Rao): nothing is fitted, it costs one Gauss-Newton step where a fit takes
    hundreds. Every output answers every input, and starts in every record, with a residue of its
    own, so that this is no less than what one shape gives.
    """
    p, m = fit.parameters, len(fit.parameters.psi)
    r, records = p.participation.shape[1], len(p.transient)
    # Modes of shape zero leave the response as it is; with no anchor, all of a shape is free.
    more = replace(
        p,
        omega=np.append(p.omega, np.full(r + records, abs(pole))),
        zeta=np.append(p.zeta, np.full(r + records, -pole.real / abs(pole))),
        psi=np.hstack([p.psi, np.zeros((m, r + records))]),
        anchor=np.append(p.anchor, np.full(r + records, -1)),
        participation=np.vstack([p.participation, np.eye(r), np.zeros((records, r))]),
        transient=np.hstack([p.transient, np.zeros((records, r)), np.eye(records)]),
    )
    responses = [frequency_response(p, s, fit.hold, fit.w_max) for s in spectra]
    whiten = [whitener(covariance(fit.noise, G)) for G in responses]
    found = equations(more, spectra, whiten, fit.hold, fit.w_max, fit.residual)
    # What multiplies a shape of zero has no derivative.
    at = np.flatnonzero(np.diag(found.gram) > 0)
    scale = np.sqrt(np.diag(found.gram)[at])
    gram, right = found.gram[np.ix_(at, at)] / np.outer(scale, scale), found.right[at] / scale
    return float(right @ np.linalg.lstsq(gram, right, rcond=1e-13)[0])
