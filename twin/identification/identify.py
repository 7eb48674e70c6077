"""From recordings to an identified model: the whole chain on one screen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError
from twin.identification.choice import Start, believable_fits
from twin.identification.discrete import predict, realize
from twin.identification.doubts import UNEXPLAINED, doubts_of_band, doubts_of_data, doubts_of_fit
from twin.identification.doubts_of_modes import doubts_of_modes
from twin.identification.listing import FELT, not_listed
from twin.identification.maximum_likelihood import ModalFit
from twin.identification.pole_diagram import Pick
from twin.identification.proportional_damping import proportional_damping
from twin.identification.records import Records, prepare
from twin.identification.result import Identification
from twin.identification.second_order import second_order_from_poles
from twin.identification.segments import Progress
from twin.identification.starts import realizations
from twin.identification.structured import Structure, structured_second_order
from twin.identification.wide_result import affordable, identify_picked, identify_wide, is_wide
from twin.modal import ModalModel
from twin.recording import Recording

ComplexArray = NDArray[np.complex128]

BELIEVABLE = 1e-4
"""Below this probability the identified residues are not those of a symmetric structure."""


def identify(
    recordings: Sequence[Recording],
    order: int | None = None,
    p: int | None = None,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    band_hz: tuple[float, float] | None = None,
    progress: Progress | None = None,
    pick: Pick | None = None,
) -> Identification:
    """Identify a linear model from one or several recordings of the same structure.

    OKID and ERA give the order and a first model, eqs. (21)-(40); a maximum-likelihood fit of
    the modal parameters in the frequency domain, started from there, removes their bias; the
    second-order model follows by eq. (41), proportional damping by eqs. (42)-(46). Where many
    lines and channels make that long, least-squares complex frequency gives the first model and
    the band is refined in segments.

    Args:
        recordings: at the same sampling rate, with common outputs.
        order: number of states; chosen from the singular values by default.
        p: number of observer Markov parameters; chosen from the length by default.
        inputs: channels that drive; forces that move, or the ground's acceleration.
        outputs: channels that respond; all others by default.
        band_hz: frequencies to use; by default what the input excites, below 1/2.56 of the rate.
        progress: told what is done, which step it is and of how many.
        pick: chooses poles in the stabilisation diagram; the modes are theirs and no others.

    Raises:
        TwinError: the recordings do not allow it; the message says why.
    """
    try:
        records = prepare(recordings, inputs, outputs)
        if pick is not None:
            found = identify_picked(records, band_hz, pick, progress)
        else:
            found = _best(records, order, p, band_hz, progress)
        fit = found.fit
        band = (fit.w_min / (2 * np.pi), fit.w_max / (2 * np.pi)) if fit else (0.0, np.inf)
        first = doubts_of_fit(found.nrmse, band)
        first += doubts_of_data(recordings, records.inputs, (*records.outputs, *records.still))
        first += doubts_of_band(records.u, records.dt, band_hz, recordings[0].source)
        first += doubts_of_modes(found)
        return replace(found, notes=(*first, *found.notes))
    except np.linalg.LinAlgError as error:
        raise IdentificationError(
            f"{recordings[0].source}: the numerical solution failed ({error}); look for outliers"
        ) from None
    except IdentificationError as error:
        source = recordings[0].source if recordings else ""
        if source in str(error):
            raise
        raise IdentificationError(f"{source}: {error}") from None


def _best(
    records: Records,
    order: int | None,
    p: int | None,
    band_hz: tuple[float, float] | None,
    progress: Progress | None,
) -> Identification:
    """Take the route that suits the records, and the other where that one finds no structure."""
    by_hand = order is not None or p is not None
    if not by_hand and is_wide(records, band_hz):
        return _whole(records, band_hz, identify_wide(records, band_hz, progress), progress)
    try:
        found = _identify(records, order, p, band_hz)
    except IdentificationError:
        if by_hand:
            raise
        return identify_wide(records, band_hz, progress)
    if by_hand or _sound(found):
        return found
    try:
        other = identify_wide(records, band_hz, progress)
    except IdentificationError:
        return found
    return found if _possible(found) and _bic(found) <= _bic(other) else other


def _whole(
    records: Records,
    band_hz: tuple[float, float] | None,
    found: Identification,
    progress: Progress | None,
) -> Identification:
    """Fit all modes at once from what the segments gave, where that is affordable and likelier.

    Segments have a noise level each; the fit at once knows the noise of the measured inputs, which
    is loud where the structure is.
    """
    assert found.fit is not None
    if not affordable(records, found.fit):
        return found
    if progress:
        progress("all modes at once", 1, 1)
    poles = 2 * np.pi * found.modal.natural_freq * _unit_pole(found.modal.damping_ratio)
    # The segments have looked beyond the band's end with noise levels of their own.
    outside = bool(np.any(found.fit.parameters.omega > found.fit.w_max))
    start = Start("least-squares complex frequency", poles, found.fit.hold, outside)
    try:
        whole = _identify(records, None, None, band_hz, start)
    except IdentificationError:
        return found
    return whole if _possible(whole) and _bic(whole) < _bic(found) else found


def _unit_pole(damping_ratio: NDArray[np.float64]) -> ComplexArray:
    return np.asarray(-damping_ratio + 1j * np.sqrt(1 - damping_ratio**2))


def _possible(found: Identification) -> bool:
    """Whether every mode loses energy and is known better than it is large."""
    std = found.modal.damping_ratio_std
    assert std is not None
    return bool(np.all(found.modal.damping_ratio > 0) and np.all(std < found.modal.damping_ratio))


def _bic(found: Identification) -> float:
    return found.fit.bic if found.fit else np.inf


def _sound(found: Identification) -> bool:
    return _possible(found) and found.nrmse < UNEXPLAINED


def _identify(
    records: Records,
    order: int | None,
    p: int | None,
    band_hz: tuple[float, float] | None,
    start: Start | None = None,
) -> Identification:
    found = realizations(records, p, order)
    options = []
    for origin, fit in believable_fits(records, found, band_hz, order is None, start):
        structure, believable, remarks = _second_order(fit, records)
        options.append((origin, fit, structure, remarks))
        if believable:
            break
    origin, fit, structure, remarks = options[-1 if believable else 0]
    p_fit = fit.parameters.only(fit.measured)
    modes = len(p_fit.omega)
    notes = [*records.notes]
    if start is None:
        notes.append(f"order {found.order} by {found.chosen_by}")
    if start is None and 2 * modes != found.order:
        notes.append(
            f"the data support {modes} modes inside the band (order {2 * modes}), by the Bayesian "
            "information criterion"
        )
    notes += remarks
    if fit.outside:
        notes.append(not_listed(fit.parameters.omega[modes:], FELT))
    freq_std, damping_std = (std[fit.measured] for std in fit.modal_std())
    freq_bound, damping_bound = (std[fit.measured] for std in fit.modal_std(bound=True))
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
    observer = None
    if slowing < 1.5 and 2 * modes <= found.hankel.rank:
        observer = found.hankel.realize(2 * modes, records.dt, len(records.inputs))
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
        order=len(model.A),
        second_order=structure.model if structure else None,
        second_order_std=structure.std if structure else None,
        alpha=alpha,
        beta=beta,
        inputs=records.inputs,
        outputs=records.outputs,
        sampling_hz=1 / records.dt,
        route=(
            f"maximum likelihood, input {fit.hold}"
            + (" between samples" if fit.hold == "band-limited" else " constant between samples")
            + f", started from {origin}"
            + (f" (p = {found.p})" if start is None else "")
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


def _second_order(fit: ModalFit, records: Records) -> tuple[Structure | None, bool, list[str]]:
    """Return M, K and R, whether the fit may be a structure's, and what to say about them."""
    p = fit.parameters.only(fit.measured)
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
        return None, True, [str(error)]
    structure = structured_second_order(model, fit, records.outputs, records.inputs, records.dt)
    if structure.chance >= BELIEVABLE:
        remark = "M, K and R by eq. (41), then fitted to all modal parameters"
        return structure, True, [remark]
    remark = (
        "M, K and R are those of eq. (41): the residues are not those of a symmetric structure "
        f"with forces and accelerations at the same points (probability {structure.chance:.1g})"
    )
    return Structure(model, None, structure.chance), False, [remark]
