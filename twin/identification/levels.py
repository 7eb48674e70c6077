"""Noise levels of segments, and everything linear solved for at them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.identification.projected import Projected
from twin.identification.segment import Segment, level_weights
from twin.identification.separable import project
from twin.identification.separable_terms import Drive, Terms

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def levelled(drive: Drive, terms: Terms, parts: list[Segment]) -> Projected:
    """Solve for all that is linear with one noise level for all outputs of a line.

    Where weights are in one proportion a single decomposition serves all outputs.
    """
    weight = np.ones(terms.Y.shape)
    for _ in range(2):
        done = project(drive, terms, weight, derivative=False)
        level = np.sqrt(np.mean(segment_weights(done.error, terms, parts) ** -2.0, axis=1))
        weight = np.broadcast_to(1 / level[:, None], terms.Y.shape)
    return done


def segment_weights(error: ComplexArray, terms: Terms, parts: Sequence[Segment]) -> Array:
    """Return 1 / standard deviation of the noise, white within each segment, (lines, outputs)."""
    omega = np.concatenate([s.omega for s in terms.spectra])
    floor = 1e-14 * np.mean(np.abs(terms.Y) ** 2, axis=0) + np.finfo(float).tiny
    weight, noise = np.ones(error.shape), terms.noise
    for segment in parts:
        inside = segment.holds(omega)
        if inside.any():
            weight[inside] = level_weights(error[inside], floor, noise[inside])
    return weight


def log_likelihood(drive: Drive, terms: Terms, parts: list[Segment]) -> float:
    """Return the logarithm of the likelihood of a drive's modes, but for a constant."""
    error = levelled(drive, terms, parts).error
    return 2 * float(np.sum(np.log(segment_weights(error, terms, parts))))
