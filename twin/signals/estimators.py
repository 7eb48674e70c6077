"""Quotients of averaged spectra: H1, H2 and Hv, and what their random error is."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError, available

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Estimator = Literal["H1", "H2", "Hv"]


def quotient(
    S_uu: ComplexArray, S_yu: ComplexArray, S_yy: Array, averages: float, estimator: Estimator
) -> tuple[ComplexArray, Array | None, Array | None]:
    """Return responses, multiple coherence and variance from sums of spectra over blocks.

    H1 = S_yu / S_uu is free of bias where noise is on the outputs alone, H2 = S_yy / S_uy where it
    is on the one input alone. Hv is the total least squares solution with every channel scaled to
    its own power, which for one input lies half way, sqrt(H1 H2).

    Args:
        S_uu: of the inputs, (lines, inputs, inputs).
        S_yu: of outputs and inputs, (lines, outputs, inputs).
        S_yy: power of the outputs, (lines, outputs).
        averages: number of independent blocks in the sums.
        estimator: which quotient.

    Returns:
        H, (lines, outputs, inputs); coherence, (lines, outputs); mean squared magnitude of the
        random error of H. The last two are None where there are no more blocks than inputs.

    Raises:
        RecordingError: no such estimator, or H2 of several inputs.

    Source: Bendat and Piersol, Random Data, 4th edition, chapters 6, 7 and 9; Rocklin, Crowley and
    Vold 1985 (Hv).
    """
    if estimator not in get_args(Estimator):
        raise RecordingError(f"no estimator '{estimator}'; there are {available(_NAMES)}")
    inputs = S_uu.shape[1]
    # The pseudo-inverse leaves lines alone where an input has no power at all.
    inverse = np.linalg.pinv(S_uu, rcond=1e-12, hermitian=True).astype(complex)
    H1: ComplexArray = S_yu @ inverse
    H = H1
    if estimator == "H2":
        if inputs > 1:
            raise RecordingError(f"H2 is for one input, here are {inputs}: take H1 or Hv")
        across = S_yu[:, :, 0].conj()
        known = np.abs(across) > 0
        H = np.asarray((S_yy / np.where(known, across, 1) * known)[:, :, None], complex)
    elif estimator == "Hv":
        H = _total_least_squares(S_uu, S_yu, S_yy)
    if averages <= inputs:
        return H, None, None
    explained = np.einsum("lor,lor->lo", H1, S_yu.conj()).real
    coherence = np.clip(explained / np.where(S_yy > 0, S_yy, 1), 0, 1)
    unexplained = S_yy * (1 - coherence) / (averages - inputs)
    spread = np.einsum("lii->li", inverse).real
    size = np.abs(H) ** 2 / np.maximum(np.abs(H1) ** 2, np.finfo(float).tiny)
    return H, coherence, np.asarray(unexplained[:, :, None] * spread[:, None] * size)


_NAMES = get_args(Estimator)


def _total_least_squares(S_uu: ComplexArray, S_yu: ComplexArray, S_yy: Array) -> ComplexArray:
    """Return for every output the combination of inputs and output that has least power."""
    lines, outputs, inputs = S_yu.shape
    H = np.empty((lines, outputs, inputs), complex)
    drive = np.sqrt(np.maximum(np.einsum("lii->li", S_uu).real, np.finfo(float).tiny))
    for o in range(outputs):
        level = np.sqrt(np.maximum(S_yy[:, o], np.finfo(float).tiny))
        size = np.hstack([drive, level[:, None]])
        S = np.empty((lines, inputs + 1, inputs + 1), complex)
        S[:, :inputs, :inputs] = S_uu
        S[:, inputs, :inputs] = S_yu[:, o]
        S[:, :inputs, inputs] = S_yu[:, o].conj()
        S[:, inputs, inputs] = S_yy[:, o]
        _, vectors = np.linalg.eigh(S / (size[:, :, None] * size[:, None]))
        least = vectors[:, :, 0]
        last = np.where(np.abs(least[:, -1]) > 0, least[:, -1], 1)
        # The least combination of the channels' spectra is (H, -1), up to a factor.
        H[:, o] = -(least[:, :-1] / last[:, None]).conj() * level[:, None] / drive
    return H


def repetition(taper: Array, step: int, blocks: int) -> float:
    """Return by how much overlapping blocks count for less than independent ones.

    Args:
        taper: window of a block, (samples,).
        step: samples from one block to the next.
        blocks: how many there are.

    Source: Welch 1967.
    """
    power = float(np.sum(taper**2))
    total = 1.0
    for j in range(1, blocks):
        shift = j * step
        if shift >= len(taper):
            break
        rho = (float(np.sum(taper[shift:] * taper[:-shift])) / power) ** 2
        total += 2 * (1 - j / blocks) * rho
    return total
