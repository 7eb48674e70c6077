"""Modes from frequency responses: the same estimate as from records, every input a record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError
from twin.identification.as_json import modes_as_json
from twin.identification.doubts import doubts_of_fit
from twin.identification.listing import listed_modes
from twin.identification.modal_response import frequency_response
from twin.identification.pole_diagram import Pick, PoleDiagram, of_responses
from twin.identification.segments import Progress
from twin.identification.spectra import USABLE_FRACTION, Spectrum
from twin.identification.wide_band import WideFit, fit_wide, starting_poles
from twin.modal import ModalModel
from twin.signals.responses import ResponseSet

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ResponseIdentification:
    """Modes identified from frequency responses.

    Attributes:
        modal: natural frequencies, damping ratios and shapes with standard deviations.
        found: the fit behind them and its stabilisation diagram.
        responses: what it was fitted to.
        error: RMS of measured less modelled response over RMS of the measured.
        notes: what a reader has to know, warnings first.
    """

    modal: ModalModel
    found: WideFit
    responses: ResponseSet
    error: float
    notes: tuple[str, ...]

    @property
    def diagram(self) -> PoleDiagram:
        """The stabilisation diagram over the measured responses."""
        return of_responses(self.found.diagram, self.responses.frequency_hz, self.responses.H)

    def as_json(self) -> dict[str, Any]:
        """Return the dictionary of the identification's contract; null for what records give."""
        rate = float(self.responses.frequency_hz[-1] / USABLE_FRACTION)
        order = 2 * len(self.found.fit.parameters.omega)
        return modes_as_json(self.modal, self.responses.inputs, rate, order, self.notes) | {
            "nrmse": self.error
        }


def spectra_of(responses: ResponseSet, band_hz: tuple[float, float] | None) -> list[Spectrum]:
    """Return one spectrum for each input, driven by one at every line.

    Raises:
        IdentificationError: no line lies inside the band.
    """
    f = responses.frequency_hz
    low, high = band_hz or (0.0, np.inf)
    keep = (f > 0) & (f >= low) & (f <= high)
    if keep.sum() < 8:
        raise IdentificationError(
            f"{responses.source}: {int(keep.sum())} lines lie in the band; the lines go from "
            f"{f[0]:g} to {f[-1]:g} Hz"
        )
    omega = 2 * np.pi * f[keep]
    dt = USABLE_FRACTION / float(f[-1])
    noise = responses.noise()
    unit = np.eye(len(responses.inputs), dtype=complex)
    return [
        Spectrum(
            omega, np.tile(unit[j], (len(omega), 1)), responses.H[keep, :, j], 1, dt,
            transient=False, noise=None if noise is None else noise[keep, :, j],
        )
        for j in range(len(responses.inputs))
    ]  # fmt: skip


def identify_responses(
    responses: ResponseSet,
    band_hz: tuple[float, float] | None = None,
    progress: Progress | None = None,
    pick: Pick | None = None,
) -> ResponseIdentification:
    """Identify modes from measured frequency responses.

    Args:
        responses: at common lines; accelerances give the shapes of accelerations.
        band_hz: frequencies to use; all by default.
        progress: told what is done, which step it is and of how many.
        pick: chooses poles in the stabilisation diagram; the modes are theirs and no others.

    Raises:
        IdentificationError: no mode is found.
    """
    spectra = spectra_of(responses, band_hz)
    poles, diagram = starting_poles(spectra, progress)
    if pick is not None:
        poles = pick(of_responses(diagram, responses.frequency_hz, responses.H))
        if not len(poles):
            raise IdentificationError(f"{responses.source}: no pole was chosen")
    found = fit_wide(spectra, "band-limited", poles, diagram, progress, pick is not None)
    fit = found.fit
    model = frequency_response(fit.parameters, spectra[0], fit.hold, fit.w_max)
    measured = np.stack([s.Y for s in spectra], axis=2)
    error = float(np.linalg.norm(measured - model) / np.linalg.norm(measured))
    listed = listed_modes(found)
    if not len(listed):
        raise IdentificationError(f"{responses.source}: no mode is known well enough to be named")
    modal = ModalModel(
        found.omega[listed] / (2 * np.pi), found.zeta[listed],
        fit.parameters.psi[:, found.leader[listed]], responses.outputs, *found.std[:, listed],
    )  # fmt: skip
    band = (fit.w_min / (2 * np.pi), fit.w_max / (2 * np.pi))
    notes = (
        *doubts_of_fit(error, band),
        *responses.notes,
        "from frequency responses: an exponential window's damping, if one was used, is still in "
        "the damping ratios",
    )
    return ResponseIdentification(modal, found, responses, error, notes)
