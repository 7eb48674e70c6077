"""Maximum-likelihood refinement of a modal model with noise on outputs and inputs.

The residual e = Y - G U of every frequency line has the covariance C = S_y + G S_u G^H, with
white sensor noise S_y on the outputs and S_u on the measured inputs; the cost sum e^H C^-1 e is
the errors-in-variables likelihood with the true inputs eliminated. Both noise levels are
estimated from the residual.

Source: Pintelon and Schoukens, System Identification (2012), ch. 9; output error for S_u = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError
from twin.estimation.noise import NoiseLevels, covariance, fit_noise, whitener
from twin.identification.modal_response import (
    Hold,
    ModalParameters,
    frequency_response,
    respond,
)
from twin.identification.modal_start import from_poles
from twin.identification.normal_equations import Equations, cost_of, equations, least_squares
from twin.identification.seminormal import covariance_of
from twin.identification.spectra import Spectrum

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

TOLERANCES = (1e-2, 1e-4, 1e-8)
"""Squared distances from the optimum, in standard deviations of the parameters, at which the
rounds end between which the noise levels are estimated anew: the last at 1e-4 of one."""
MAX_ZETA = 0.95
MAX_DRIFT = 1.0


@dataclass(frozen=True)
class ModalFit:
    """A maximum-likelihood modal model.

    Attributes:
        parameters: the estimate.
        hold: what the input does between its samples.
        residual: whether the out-of-band term is part of the model.
        w_max: highest analysed angular frequency [rad/s].
        noise: noise levels of outputs and inputs.
        covariance: of the parameters in the order of ``jacobian``: the bound, widened for modes
            near whose resonance the residual is larger than the noise elsewhere.
        fisher_covariance: the Cramer-Rao bound, the inverse of the Fisher information.
        log_likelihood: of the residual.
        unknowns: number of fitted parameters; outputs left free at the ends do not count, they
            stand for data that are not used.
        data: number of real data.
        w_min: lowest analysed angular frequency [rad/s].
        outside: how many of the modes, the last ones, were started above the band: felt inside it,
            but not measured. A fit by segments does not sort them so, see ``listing``.
    """

    parameters: ModalParameters
    hold: Hold
    residual: bool
    w_max: float
    noise: NoiseLevels
    covariance: Array
    fisher_covariance: Array
    log_likelihood: float
    unknowns: int
    data: int
    w_min: float = 0.0
    outside: int = 0

    @property
    def bic(self) -> float:
        """Bayesian information criterion, smaller is better."""
        return -2 * self.log_likelihood + self.unknowns * float(np.log(self.data))

    @property
    def price_of_mode(self) -> float:
        """What the criterion charges for one more mode."""
        p = self.parameters
        of_shape = 2 * (len(p.psi) - 1) + 2 * p.participation.shape[1]
        return (2 + of_shape + 2 * len(p.transient)) * float(np.log(self.data))

    @property
    def measured(self) -> slice:
        """The modes that were not started above the band, as a slice of all."""
        return slice(0, len(self.parameters.omega) - self.outside)

    def modal_std(self, bound: bool = False) -> tuple[Array, Array]:
        """Standard deviations of natural frequency [Hz] and damping ratio, or their bounds."""
        n = len(self.parameters.omega)
        std = np.sqrt(np.diag(self.fisher_covariance if bound else self.covariance))
        return std[:n] * self.parameters.omega / (2 * np.pi), std[n : 2 * n]


def pack(p: ModalParameters, residual: bool) -> Array:
    """Return the free parameters as one real vector, records one after the other."""
    free = np.arange(len(p.psi))[:, None] != p.anchor
    shapes = np.concatenate([_real(p.psi[free[:, i], i]) for i in range(len(p.omega))])
    parts = [np.log(p.omega), p.zeta, shapes, _real(p.participation.ravel()), p.D.ravel()]
    if residual:
        parts.append(p.D2.ravel())
    for c, edge in zip(p.transient, p.edges, strict=True):
        parts += [_real(c), edge.ravel()]
    return np.concatenate(parts)


def unpack(x: Array, like: ModalParameters, residual: bool) -> ModalParameters:
    """Inverse of ``pack``; sizes and anchors come from ``like``."""
    m, n = like.psi.shape
    r = like.participation.shape[1]
    cursor = 0

    def take(count: int) -> Array:
        nonlocal cursor
        cursor += count
        return x[cursor - count : cursor]

    # A mode that the data do not support runs away; bounded, it stays finite and is dropped later.
    centre = np.log(like.omega)
    omega = np.exp(np.clip(take(n), centre - MAX_DRIFT, centre + MAX_DRIFT))
    zeta = np.clip(take(n), -MAX_ZETA, MAX_ZETA)
    psi = np.ones((m, n), complex)
    for i in range(n):
        psi[np.arange(m) != like.anchor[i], i] = _complex(take(2 * (m - 1)))
    participation = _complex(take(2 * n * r)).reshape(n, r)
    D = take(m * r).reshape(m, r)
    D2 = take(m * r).reshape(m, r) if residual else np.zeros((m, r))
    transient, edges = [], []
    for edge in like.edges:
        transient.append(_complex(take(2 * n)))
        edges.append(take(edge.size).reshape(edge.shape))
    return ModalParameters(
        omega, zeta, psi, like.anchor, participation, D, D2, np.array(transient), tuple(edges)
    )


def fit_modal(
    spectra: Sequence[Spectrum],
    poles: ComplexArray,
    hold: Hold,
    residual: bool = False,
    outside: int = 0,
) -> ModalFit:
    """Fit a modal model to all records, started from poles.

    Args:
        spectra: the records.
        poles: starting poles with positive imaginary part [rad/s], (modes,).
        hold: what the input does between its samples.
        residual: include a term for modes above the band.
        outside: how many of the poles, the last ones, are started above the band.

    Raises:
        IdentificationError: more unknowns than data.
    """
    w_max = max(float(s.omega[-1]) for s in spectra)
    start = from_poles(poles, spectra, hold, w_max, residual)
    x = pack(start, residual)
    data = sum(2 * s.Y.size for s in spectra)
    if data <= 2 * len(x):
        raise IdentificationError(
            f"{len(poles)} modes have {len(x)} unknowns, too many for {data} data in the band"
        )
    # The first round blames the outputs alone: a poor start would be taken for input noise,
    # which hides the resonances from the fit and keeps it poor.
    power = np.mean([np.mean(np.abs(s.Y) ** 2, axis=0) for s in spectra], axis=0)
    noise = NoiseLevels(power, np.zeros(spectra[0].U.shape[1]))
    for tolerance in TOLERANCES:
        responses = [
            frequency_response(unpack(x, start, residual), s, hold, w_max) for s in spectra
        ]
        whiten = [whitener(covariance(noise, G)) for G in responses]
        x = _solve(x, start, spectra, whiten, hold, w_max, residual, tolerance)
        parameters = unpack(x, start, residual)
        errors = [s.Y - respond(parameters, s, i, hold, w_max) for i, s in enumerate(spectra)]
        responses = [frequency_response(parameters, s, hold, w_max) for s in spectra]
        noise = fit_noise(errors, responses, [s.U for s in spectra], len(x))
    found = _summarise(unpack(x, start, residual), spectra, noise, hold, w_max, residual)
    return replace(found, outside=outside)


def _solve(
    x: Array,
    like: ModalParameters,
    spectra: Sequence[Spectrum],
    whiten: Sequence[ComplexArray],
    hold: Hold,
    w_max: float,
    residual: bool,
    tolerance: float,
) -> Array:
    def linearised(x: Array) -> Equations:
        return equations(unpack(x, like, residual), spectra, whiten, hold, w_max, residual)

    def cost(x: Array) -> float:
        return cost_of(unpack(x, like, residual), spectra, whiten, hold, w_max)

    return least_squares(x, linearised, cost, tolerance)


def _summarise(
    p: ModalParameters,
    spectra: Sequence[Spectrum],
    noise: NoiseLevels,
    hold: Hold,
    w_max: float,
    residual: bool,
) -> ModalFit:
    covariances = [covariance(noise, frequency_response(p, s, hold, w_max)) for s in spectra]
    whiten = [whitener(C) for C in covariances]
    n = len(p.omega)
    found = equations(p, spectra, whiten, hold, w_max, residual, kept=2 * n)
    bound = covariance_of(found.gram)
    misfit = np.ones(len(bound))
    assert found.kept is not None
    misfit[: 2 * n] = [_misfit(found.kept[:, i], found.white) for i in range(2 * n)]
    log_det = sum(float(np.sum(np.linalg.slogdet(C)[1])) for C in covariances)
    return ModalFit(
        parameters=replace(p),
        hold=hold,
        residual=residual,
        w_max=w_max,
        noise=noise,
        covariance=bound * np.outer(misfit, misfit),
        fisher_covariance=bound,
        log_likelihood=-log_det - found.cost / 2,
        unknowns=len(bound) - sum(edge.size for edge in p.edges),
        data=2 * found.white.size,
        w_min=min(float(s.omega[0]) for s in spectra),
    )


def _misfit(sensitivity: ComplexArray, white: ComplexArray) -> float:
    """Return by how much the residual exceeds the noise where a parameter has its information.

    The whitened residual's power, weighted with the information each line holds; 1 unless it is
    larger than chance allows (three and a half standard deviations).
    """
    weight = np.abs(sensitivity) ** 2
    power = float(np.sum(weight * np.abs(white) ** 2) / np.sum(weight))
    lines = float(np.sum(weight) ** 2 / np.sum(weight**2))
    return float(np.sqrt(power)) if power > 1 + 3.5 / np.sqrt(lines) else 1.0


def _real(values: ComplexArray) -> Array:
    """Interleave real and imaginary parts."""
    return np.column_stack([values.real, values.imag]).ravel()


def _complex(values: Array) -> ComplexArray:
    return values[0::2] + 1j * values[1::2]
