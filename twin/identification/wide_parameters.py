"""A wide-band estimate as a modal fit: parameters, covariance and where noise is not white."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.estimation.noise import NoiseLevels
from twin.identification.maximum_likelihood import ModalFit
from twin.identification.modal_response import ModalParameters
from twin.identification.projected import Projected
from twin.identification.seminormal import covariance_of
from twin.identification.separable_terms import Drive, Terms

Array = NDArray[np.float64]


def as_fit(drive: Drive, done: Projected, terms: Terms, weight: Array, w_min: float) -> ModalFit:
    """Return the fit of a drive whose linear parameters are solved for.

    Args:
        drive: poles and participations.
        done: everything linear at that drive, with Gauss-Newton's equations.
        terms: the records and the terms beside the modes.
        weight: reciprocal standard deviation of the noise, (lines, outputs).
        w_min: lowest analysed angular frequency [rad/s].
    """
    n, q = drive.v.shape
    m, r = terms.Y.shape[1], terms.spectra[0].U.shape[1]
    anchor = np.argmax(np.abs(done.psi), axis=0)
    size = done.psi[anchor, np.arange(n)]
    free = np.zeros((len(terms.spectra), n), complex)
    column, edges, row = r, [], r * len(terms.powers)
    for index, s in enumerate(terms.spectra):
        if s.transient:
            free[index] = drive.v[:, column] * size
            column += 1
        edges.append(done.direct[row : row + s.edge_columns.shape[1]])
        row += s.edge_columns.shape[1]
    D = [done.direct[i * r : (i + 1) * r].T for i in range(len(terms.powers))]
    p = ModalParameters(
        drive.omega, drive.zeta, done.psi / size, anchor,
        drive.v[:, :r] * size[:, None], D[0], D[1], free, tuple(edges), D[2],
    )  # fmt: skip
    assert done.gram is not None
    inverse = covariance_of(done.gram)
    covariance = inverse.reshape(n, q, 2, n, q, 2)
    first = covariance[:, 0, :, :, 0, :].transpose(1, 0, 3, 2).reshape(2 * n, 2 * n)
    scale = np.concatenate([np.ones(n), drive.zeta])
    bound = first * np.outer(scale, scale)
    misfit = np.tile(misfits(drive, done, terms, weight), 2)
    log_likelihood = 2 * float(np.sum(np.log(weight))) - done.cost / 2
    linear = m * (2 * n + r * len(terms.powers))
    return ModalFit(
        parameters=p,
        hold=terms.hold,
        residual=True,
        w_max=terms.w_max,
        noise=NoiseLevels(np.mean(np.abs(done.error) ** 2, axis=0), np.zeros(r)),
        covariance=bound * np.outer(misfit, misfit),
        fisher_covariance=bound,
        log_likelihood=log_likelihood,
        unknowns=linear + 2 * n * q,
        data=2 * terms.Y.size,
        w_min=w_min,
    )


def misfits(drive: Drive, done: Projected, terms: Terms, weight: Array) -> Array:
    """By how much the residual exceeds its level within each mode's bandwidth, at least 1, (n,)."""
    omega = np.concatenate([s.omega for s in terms.spectra])
    power = np.mean(np.abs(done.error * weight) ** 2, axis=1)
    found = np.ones(len(drive.omega))
    for i, (centre, zeta) in enumerate(zip(drive.omega, drive.zeta, strict=True)):
        x = (omega - centre) / max(zeta * centre, 1e-12)
        information = 1 / (1 + x**2) ** 2
        lines = float(np.sum(information) ** 2 / np.sum(information**2)) * done.error.shape[1]
        excess = float(np.sum(information * power) / np.sum(information))
        if excess > 1 + 3.5 / np.sqrt(lines):
            found[i] = np.sqrt(excess)
    return found
