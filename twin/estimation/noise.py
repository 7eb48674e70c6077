"""Noise levels of outputs and inputs from the residual of a linear model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

ROUNDING = 1e-7
"""Smallest noise variance as a share of the response's power: 70 dB below the response no chain
of instruments measures, and nothing down there is evidence for another mode."""


@dataclass(frozen=True)
class NoiseLevels:
    """Variances of white noise on outputs (m,) and inputs (r,), in squared SI units."""

    output: Array
    input: Array


def covariance(noise: NoiseLevels, G: ComplexArray) -> ComplexArray:
    """Return S_y + G S_u G^H for every line, (bins, m, m)."""
    C = np.matmul(G * noise.input, G.conj().transpose(0, 2, 1))
    C[:, range(len(noise.output)), range(len(noise.output))] += noise.output
    return C


def whitener(C: ComplexArray) -> ComplexArray:
    """Return W with W C W^H = 1 for every line, (bins, m, m)."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky(C)))


def fit_noise(
    errors: Sequence[ComplexArray],
    responses: Sequence[ComplexArray],
    inputs: Sequence[ComplexArray],
    unknowns: int,
) -> NoiseLevels:
    """Fit the variances of output and input noise to residual spectra by maximum likelihood.

    Args:
        errors: residual spectra, one (bins, m) a record.
        responses: the model's FRF, one (bins, m, r) a record.
        inputs: measured input spectra, one (bins, r) a record.
        unknowns: number of fitted parameters, for the lost degrees of freedom.
    """
    e, G, U = np.vstack(list(errors)), np.vstack(list(responses)), np.vstack(list(inputs))
    m, r = G.shape[1:]
    e = e / np.sqrt(max(1 - unknowns / (2 * e.size), 0.1))
    power = np.mean(np.abs(np.einsum("kmr,kr->km", G, U)) ** 2, axis=0)
    scale_y = np.mean(np.abs(e) ** 2, axis=0)
    least = ROUNDING * power + np.finfo(float).tiny
    scale_y = np.maximum(scale_y, least)
    # The input noise that would explain the whole residual by itself.
    gain = np.mean(np.abs(G) ** 2, axis=0) + np.finfo(float).tiny
    scale_u = np.min(scale_y[:, None] / gain, axis=0)
    scales = np.concatenate([scale_y, scale_u])

    def cost(logs: Array) -> tuple[float, Array]:
        level = scales * np.exp(logs)
        C = covariance(NoiseLevels(level[:m], level[m:]), G)
        inverse = np.linalg.inv(C)
        v = np.einsum("kij,kj->ki", inverse, e)
        value = np.sum(np.linalg.slogdet(C)[1]) + np.sum(np.real(e.conj() * v))
        by_output = np.sum(np.real(np.einsum("kii->ki", inverse)) - np.abs(v) ** 2, axis=0)
        trace = np.real(np.einsum("kir,kij,kjr->kr", G.conj(), inverse, G, optimize=True))
        by_input = np.sum(trace - np.abs(np.einsum("kir,ki->kr", G.conj(), v)) ** 2, axis=0)
        slope = np.concatenate([by_output, by_input]) * level
        return float(value) / len(e), slope / len(e)

    guess = np.concatenate([np.zeros(m), np.full(r, np.log(0.1))])
    lowest = np.maximum(np.log(least / scale_y), -12.0)
    bounds = [(low, 2.0) for low in lowest] + [(-16.0, 12.0)] * r
    found = optimize.minimize(cost, guess, jac=True, method="L-BFGS-B", bounds=bounds)
    level = scales * np.exp(found.x)
    return NoiseLevels(level[:m], level[m:])
