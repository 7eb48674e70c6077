"""A wide-band modal test from records to result."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError
from twin.identification.discrete import predict, realize
from twin.identification.listing import FELT, listed_modes, not_listed
from twin.identification.maximum_likelihood import ModalFit
from twin.identification.modal_response import Hold
from twin.identification.pole_diagram import Pick, of_records
from twin.identification.proportional_damping import proportional_damping
from twin.identification.records import Records
from twin.identification.result import Identification
from twin.identification.second_order import second_order_from_poles
from twin.identification.segments import Progress
from twin.identification.wide_band import WideFit, fit_wide, starting_poles
from twin.modal import ModalModel

DATA = 8_000
"""Complex data in the band beyond which fits of all modes at once from every start that OKID and
ERA give take minutes."""

OPERATIONS = 1e9
"""Multiplications of one Gauss-Newton step, data times unknowns squared, up to which all modes are
fitted at once from the poles that the segments gave: a fifth of a second a step on one core."""


def is_wide(records: Records, band_hz: tuple[float, float] | None) -> bool:
    """Whether the records hold too many data for the fit of all modes at once."""
    return sum(s.Y.size for s in records.spectra(band_hz, edges=False)) > DATA


def affordable(records: Records, fit: ModalFit) -> bool:
    """Whether all modes of a fit by segments can be refined at once in seconds."""
    modes, inputs = fit.parameters.participation.shape
    outputs, count = len(records.outputs), len(records.u)
    unknowns = modes * 2 * (outputs + inputs + count) + 2 * outputs * inputs
    return fit.data * float(unknowns) ** 2 < OPERATIONS


def identify_wide(
    records: Records, band_hz: tuple[float, float] | None, progress: Progress | None
) -> Identification:
    """Identify all modes of a wide band.

    Raises:
        IdentificationError: no mode is found, or the data are too few.
    """
    spectra = records.wide_spectra(band_hz)
    poles, diagram = starting_poles(spectra, progress)
    return _result(records, fit_wide(spectra, None, poles, diagram, progress))


def identify_picked(
    records: Records, band_hz: tuple[float, float] | None, pick: Pick, progress: Progress | None
) -> Identification:
    """Identify the modes whose poles are chosen in the stabilisation diagram.

    Raises:
        IdentificationError: no pole is chosen, or more than the data determine.
    """
    spectra = records.wide_spectra(band_hz)
    _, diagram = starting_poles(spectra, progress)
    poles = pick(of_records(diagram, records.pairs, 1 / records.dt))
    if not len(poles):
        raise IdentificationError("no pole was chosen")
    return _result(records, fit_wide(spectra, None, poles, diagram, progress, by_hand=True))


def _result(records: Records, found: WideFit) -> Identification:
    fit = found.fit
    p = fit.parameters
    listed = listed_modes(found)
    if not len(listed):
        raise IdentificationError(
            "no mode is known well enough to be named: no damping ratio can be told from zero"
        )
    rank = found.leader[listed]
    freq, zeta = found.omega[listed] / (2 * np.pi), found.zeta[listed]
    freq_std, damping_std = found.std[:, listed]
    freq_bound, damping_bound = (bound[rank] for bound in fit.modal_std(bound=True))
    predicted = tuple(predict(fit, u, y, records.dt) for u, y in records.pairs)
    notes = list(records.notes)
    alpha = beta = None
    if len(rank) >= 2:
        alpha, beta = proportional_damping(freq, zeta)
    several = [k for k in listed if len(found.families[k]) > 1]
    if several:
        at = ", ".join(f"{found.omega[k] / (2 * np.pi):.5g}" for k in several)
        notes.append(
            f"at {at} Hz several poles of one shape share a bandwidth: a mode whose frequency or "
            "damping depends on amplitude, or a pair that these sensors do not separate; the list "
            "holds one mode that answers as they do together, the model all of them"
        )
    notes += _not_listed(found, listed)
    if found.by_hand:
        notes.append("the modes are those chosen in the stabilisation diagram, by hand")
        vague = np.flatnonzero(found.zeta <= 1.96 * found.std[1])
        if len(vague):
            at = ", ".join(f"{f / (2 * np.pi):.5g}" for f in np.sort(found.omega[vague]))
            notes.insert(0, f"warning: the damping chosen at {at} Hz cannot be told from zero")
    second_order = None
    if len(p.omega) == len(rank):
        try:
            second_order = second_order_from_poles(
                p.poles, p.psi, _continuous(p.participation, p.poles, fit.hold, records.dt),
                records.outputs, records.inputs,
            )  # fmt: skip
        except IdentificationError as error:
            notes.append(str(error))
    else:
        notes.append("M, K and R need as many modes as measured accelerations")
    model = realize(fit, records.pairs, records.dt, None)
    notes.append("G: this route has no observer")
    result = Identification(
        modal=ModalModel(
            freq, zeta, p.psi[:, rank], records.outputs, freq_std, damping_std
        ),
        state_space=model,
        singular_values=np.zeros(0),
        order=2 * len(p.omega),
        second_order=second_order,
        alpha=alpha,
        beta=beta,
        inputs=records.inputs,
        outputs=records.outputs,
        sampling_hz=1 / records.dt,
        route=(
            f"variable projection in segments of the band, input {fit.hold} between samples, "
            "started from least-squares complex frequency"
        ),
        recordings=records.recordings,
        predicted=predicted,
        diagram=found.diagram,
        fit=fit,
        natural_freq_bound=freq_bound,
        damping_ratio_bound=damping_bound,
        notes=tuple(notes),
    )  # fmt: skip
    return result


def _not_listed(found: WideFit, listed: NDArray[np.intp]) -> list[str]:
    """Say which poles are part of the model and not of the list."""
    left = np.setdiff1d(np.arange(len(found.omega)), listed)
    beyond = (found.omega < found.fit.w_min) | (found.omega > found.fit.w_max)
    notes = []
    for poles, why in (
        (left[~beyond[left]], "improve the fit, but their damping cannot be told from zero"),
        (left[beyond[left]], FELT),
    ):
        if len(poles):
            notes.append(not_listed(found.omega[poles], why))
    return notes


def _continuous(participation: np.ndarray, poles: np.ndarray, hold: Hold, dt: float) -> np.ndarray:
    if hold == "band-limited":
        return participation
    return np.asarray(participation * (poles / (np.exp(poles * dt) - 1))[:, None])
