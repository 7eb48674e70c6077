"""Which fit to believe: starting points, inter-sample behaviour and number of modes compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError
from twin.identification.maximum_likelihood import ModalFit, fit_modal
from twin.identification.modal_response import Hold
from twin.identification.outside import stays_outside, with_pole_outside
from twin.identification.records import Records
from twin.identification.spectra import Spectrum
from twin.identification.starts import Realizations, candidate_poles
from twin.modal import mac

ComplexArray = NDArray[np.complex128]

HOLDS: tuple[Hold, ...] = ("band-limited", "held")
OUT_OF_BAND = 1.02
HEAVY = 0.5
"""A mode with more damping than this is a smooth background, not a resonance."""

VAGUE = 0.01
"""A mode whose frequency is known no better than to this share is a background, not a mode."""

SAME_SHAPE = 0.99
"""MAC above which two modes within one bandwidth are one."""

PATIENCE = 2
"""Models in a row that are worse for having lost a mode before the search ends."""

CERTAIN = 2.0
"""Multiple of the root of a mode's price beyond which its damping's distance from none, in
standard deviations, leaves no doubt: the rise of the criterion without the mode is then at least
the square of that distance, four times the price."""

DECISIVE = 20.0
"""Difference in BIC below which records do not tell how the input behaves between samples."""


@dataclass(frozen=True)
class Attempt:
    """A fit and where it started.

    Attributes:
        origin: of the starting poles, in words.
        poles: starting poles [rad/s], (modes,).
        fit: the maximum-likelihood fit from there.
    """

    origin: str
    poles: ComplexArray
    fit: ModalFit


@dataclass(frozen=True)
class Start:
    """Poles found by other means than OKID and ERA.

    Attributes:
        origin: of the poles, in words.
        poles: [rad/s], (modes,).
        hold: what the input does between its samples.
        outside: whether a pole above the band was felt there; else none is tried.
    """

    origin: str
    poles: ComplexArray
    hold: Hold
    outside: bool


def best_attempts(
    records: Records,
    found: Realizations,
    band_hz: tuple[float, float] | None,
    start: Start | None = None,
) -> list[Attempt]:
    """Fit from every starting point and for either inter-sample behaviour, or from a given start.

    Returns:
        The best attempt for each behaviour.

    Raises:
        IdentificationError: no starting point leads to a fit.
    """
    best: list[Attempt] = []
    problem = "no oscillating pole was found"
    # The same samples are left free whatever the hold, so that likelihoods can be compared.
    spectra = records.spectra(band_hz, edges=True)
    top = max(float(s.omega[-1]) for s in spectra)
    starts = [(start.origin, start.poles)] if start else candidate_poles(found)
    for hold in (start.hold,) if start else HOLDS:
        attempts = []
        for name, poles in starts:
            inside = poles[np.abs(poles) < OUT_OF_BAND * top]
            if not len(inside):
                continue
            try:
                attempts.append(Attempt(name, inside, fit_modal(spectra, inside, hold)))
            except IdentificationError as error:
                problem = str(error)
        if attempts:
            best.append(min(attempts, key=lambda attempt: attempt.fit.bic))
    if not best:
        raise IdentificationError(f"the refinement found no model: {problem}")
    return best


def believable_fits(
    records: Records,
    found: Realizations,
    band_hz: tuple[float, float] | None,
    prune: bool,
    start: Start | None = None,
) -> list[tuple[str, ModalFit]]:
    """Return the fits the records allow, the one to believe first in front, with their origins.

    Each behaviour of the input between samples gets its own best number of modes and, where the
    evidence asks for it, the out-of-band term and a pole above the band. One that is decisively
    better stands alone; else the band-limited input comes first, which an analyser with an
    anti-alias filter delivers.

    Args:
        records: prepared recordings.
        found: OKID and ERA's realizations.
        band_hz: frequencies to use, or None for what the input excites.
        prune: whether modes may be dropped, and one above the band be added (not where the order
            was given by hand).
        start: where to start instead of what OKID and ERA say.

    Raises:
        IdentificationError: no starting point leads to a fit.
    """
    spectra = records.spectra(band_hz, edges=True)
    fits = []
    for attempt in best_attempts(records, found, band_hz, start):
        fit = attempt.fit
        fuller = fit_modal(spectra, attempt.poles, fit.hold, residual=True)
        fit = fuller if fuller.bic < fit.bic else fit
        if prune:
            fit = _fewer_modes(fit, attempt.poles, spectra)
            fit = _with_flank(fit, spectra) if start is None or start.outside else fit
        fits.append((attempt.origin, fit))
    least = min(fit.bic for _, fit in fits)
    allowed = [(origin, fit) for origin, fit in fits if fit.bic < least + DECISIVE]
    return [(origin, _with_all_samples(fit, records, band_hz)) for origin, fit in allowed]


def _with_all_samples(
    fit: ModalFit, records: Records, band_hz: tuple[float, float] | None
) -> ModalFit:
    """Use the record's ends too, where the input is held and they hold no surprise."""
    spectra = records.spectra(band_hz, edges=False)
    if fit.hold == "band-limited" or not any(s.edge for s in records.spectra(band_hz, True)):
        return fit
    whole = fit_modal(spectra, fit.parameters.poles, fit.hold, fit.residual, fit.outside)
    return whole if stays_outside(whole, spectra) else fit


def _with_flank(fit: ModalFit, spectra: Sequence[Spectrum]) -> ModalFit:
    """Try a pole above the band, and where it pays drop the modes that it makes needless.

    It comes last, so that fits which need none stay what they are.
    """
    felt = with_pole_outside(fit, spectra)
    if not felt.outside:
        return fit
    felt = _fewer_modes(felt, felt.parameters.poles, spectra)
    return felt if stays_outside(felt, spectra) and felt.bic < fit.bic else fit


def _fewer_modes(fit: ModalFit, poles: ComplexArray, spectra: Sequence[Spectrum]) -> ModalFit:
    """Drop modes that no structure has, then every mode the data are better off without.

    Every smaller model starts from the starting poles that are left, not from where a larger
    model took them. A mode whose damping is so many standard deviations from none that without it
    the likelihood must fall by far more than its unknowns cost is not tried. The best of the
    models whose modes all lose energy, lie inside the band and are resonances is returned; the
    best of all where there is none. A pole above the band, the last of all, is carried along.
    """
    tried = [fit]
    rises = 0
    while len(poles) - fit.outside > 1 and rises < PATIENCE:
        last = tried[-1]
        impossible = _impossible(last, spectra)
        damping_std = last.modal_std(bound=True)[1][last.measured]
        vague = damping_std / np.maximum(np.abs(last.parameters.zeta[last.measured]), 1e-6)
        if not impossible.any() and np.max(vague) * CERTAIN * np.sqrt(last.price_of_mode) < 1:
            break
        poles = np.delete(poles, int(np.argmax(np.where(impossible, np.inf, vague))))
        tried.append(fit_modal(spectra, poles, fit.hold, fit.residual, fit.outside))
        rises = 0 if impossible.any() or tried[-1].bic < last.bic else rises + 1
    possible = [
        trial
        for trial in tried
        if not _impossible(trial, spectra).any() and stays_outside(trial, spectra)
    ]
    return min(possible or tried, key=lambda trial: trial.bic)


def _impossible(fit: ModalFit, spectra: Sequence[Spectrum]) -> NDArray[np.bool_]:
    """Modes that gain energy, are no resonances, are vague, outside the band, or repeat another.

    What was started above the band is not judged.
    """
    p = fit.parameters.only(fit.measured)
    top = max(float(s.omega[-1]) for s in spectra)
    found = np.asarray((p.zeta <= 0) | (p.zeta > HEAVY) | (p.omega > top))
    freq_std = fit.modal_std()[0][fit.measured]
    found |= freq_std > VAGUE * p.omega / (2 * np.pi)
    damping_std = fit.modal_std(bound=True)[1][fit.measured]
    alike = mac(p.psi, p.psi) > SAME_SHAPE
    for i, j in np.argwhere(np.triu(alike, 1)):
        # A structure that softens with amplitude shows as two modes within one bandwidth.
        bandwidth = p.zeta[i] * p.omega[i] + p.zeta[j] * p.omega[j]
        if abs(p.omega[i] - p.omega[j]) < abs(bandwidth):
            found[i if damping_std[i] > damping_std[j] else j] = True
    return found
