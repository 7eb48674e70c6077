"""From recordings to an identified model: the whole chain on one screen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError
from twin.identification.discrete import predict, realize
from twin.identification.maximum_likelihood import ModalFit, fit_modal
from twin.identification.modal_response import Hold
from twin.identification.proportional_damping import proportional_damping
from twin.identification.records import Records, prepare
from twin.identification.result import Identification
from twin.identification.second_order import second_order_from_poles
from twin.identification.spectra import Spectrum
from twin.identification.starts import Realizations, candidate_poles, realizations
from twin.identification.structured import structured_second_order
from twin.modal import ModalModel
from twin.recording import Recording
from twin.second_order import SecondOrderModel

ComplexArray = NDArray[np.complex128]

HOLDS: tuple[Hold, ...] = ("band-limited", "held")
OUT_OF_BAND = 1.3
HEAVY = 0.5
"""A mode with more damping than this is a smooth background, not a resonance."""
BELIEVABLE = 1e-4
"""Below this probability the identified residues are not those of a symmetric structure."""


def identify(
    recordings: Sequence[Recording],
    order: int | None = None,
    p: int | None = None,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    band_hz: tuple[float, float] | None = None,
) -> Identification:
    """Identify a linear model from one or several recordings of the same structure.

    OKID and ERA give the order and a first model, eqs. (21)-(40); a maximum-likelihood fit of
    the modal parameters in the frequency domain, started from there, removes their bias; the
    second-order model follows by eq. (41), proportional damping by eqs. (42)-(46).

    Args:
        recordings: at the same sampling rate, with common outputs.
        order: number of states; chosen from the singular values by default.
        p: number of observer Markov parameters; chosen from the length by default.
        inputs: channels that drive; forces that move, or the ground's acceleration.
        outputs: channels that respond; all others by default.
        band_hz: frequencies to use; by default what the input excites, below 1/2.56 of the rate.

    Raises:
        TwinError: the recordings do not allow it; the message says why.
    """
    records = prepare(recordings, inputs, outputs)
    found = realizations(records, p, order)
    origin, fit = refine(records, found, band_hz, prune=order is None)
    notes = [*records.notes, f"order {found.order} by {found.chosen_by}"]
    if 2 * len(fit.parameters.omega) != found.order:
        notes.append(f"{found.order} states gave {len(fit.parameters.omega)} modes inside the band")
    second_order, remarks = _second_order(fit, records)
    notes += remarks
    p_fit = fit.parameters
    freq_std, damping_std = fit.modal_std()
    freq_bound, damping_bound = fit.modal_std(bound=True)
    freq = p_fit.omega / (2 * np.pi)
    rank = np.argsort(freq)
    alpha = beta = None
    if len(freq) >= 2:
        alpha, beta = proportional_damping(freq[rank], p_fit.zeta[rank])
    else:
        notes.append("alpha and beta need two modes")
    slowing = found.records.dt / records.dt
    if slowing > 1.5:
        notes.append(
            f"OKID and ERA ran at {1 / found.records.dt:.4g} Hz: the input excites nothing above"
        )
    observer = found.observer if slowing < 1.5 else None
    edges = [s.edge for s in records.spectra(band_hz, fit.hold == "band-limited")]
    model = realize(fit, records.pairs, records.dt, observer)
    if model.G is None:
        notes.append("G: no stable observer gain belongs to the refined poles")
    return Identification(
        modal=ModalModel(
            freq[rank],
            p_fit.zeta[rank],
            p_fit.psi[:, rank],
            records.outputs,
            freq_std[rank],
            damping_std[rank],
        ),
        state_space=model,
        singular_values=found.hankel.singular_values,
        order=2 * len(freq),
        second_order=second_order,
        alpha=alpha,
        beta=beta,
        inputs=records.inputs,
        outputs=records.outputs,
        sampling_hz=1 / records.dt,
        route=(
            f"maximum likelihood, input {fit.hold}"
            + (" between samples" if fit.hold == "band-limited" else " constant between samples")
            + f", started from {origin} (p = {found.p})"
        ),
        recordings=records.recordings,
        predicted=tuple(
            predict(fit, u, y, records.dt, edge)
            for (u, y), edge in zip(records.pairs, edges, strict=True)
        ),
        diagram=found.diagram,
        fit=fit,
        natural_freq_bound=freq_bound[rank],
        damping_ratio_bound=damping_bound[rank],
        notes=tuple(notes),
    )


def refine(
    records: Records,
    found: Realizations,
    band_hz: tuple[float, float] | None,
    prune: bool,
) -> tuple[str, ModalFit]:
    """Fit from every starting point and input hold; return the most likely fit and its origin.

    Raises:
        IdentificationError: no starting point leads to a fit.
    """
    fits: list[tuple[str, ModalFit]] = []
    problem = "no oscillating pole was found"
    # The same samples are left free whatever the hold, so that likelihoods can be compared.
    spectra = records.spectra(band_hz, edges=True)
    top = max(float(s.omega[-1]) for s in spectra)
    for hold in HOLDS:
        for name, poles in candidate_poles(found):
            inside = poles[np.abs(poles) < OUT_OF_BAND * top]
            try:
                fits.append((name, fit_modal(spectra, inside, hold)))
            except IdentificationError as error:
                problem = str(error)
    if not fits:
        raise IdentificationError(f"the refinement found no model: {problem}")
    name, fit = min(fits, key=lambda named: named[1].bic)
    fuller = fit_modal(spectra, fit.parameters.poles, fit.hold, residual=True)
    fit = fuller if fuller.bic < fit.bic else fit
    fit = _without_needless_modes(fit, spectra) if prune else fit
    if fit.hold == "held" and any(s.edge for s in spectra):
        spectra = records.spectra(band_hz, edges=False)
        fit = fit_modal(spectra, fit.parameters.poles, fit.hold, fit.residual)
    return name, fit


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


def _second_order(fit: ModalFit, records: Records) -> tuple[SecondOrderModel | None, list[str]]:
    p = fit.parameters
    participation = p.participation
    if fit.hold == "held":
        # The pulse-transfer residue of a held input is the continuous one times (e^{l dt} - 1) / l.
        gain = p.poles / (np.exp(p.poles * records.dt) - 1)
        participation = participation * gain[:, None]
    try:
        model = second_order_from_poles(
            p.poles, p.psi, participation, records.outputs, records.inputs
        )
    except IdentificationError as error:
        return None, [str(error)]
    refined, chance = structured_second_order(
        model, fit, records.outputs, records.inputs, records.dt
    )
    if chance < BELIEVABLE:
        return model, [
            "M, K and R are those of eq. (41): the residues are not those of a symmetric "
            "structure with forces and accelerations at the same points "
            f"(probability {chance:.1g})"
        ]
    return refined, ["M, K and R agree best with all modal parameters, started from eq. (41)"]
