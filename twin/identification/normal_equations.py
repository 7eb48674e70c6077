"""Gauss-Newton's normal equations of a modal model, record by record, and their iteration.

The regressors of all records are never held at once: a record's part of the Gram matrix is
added and forgotten, an order faster than the QR decomposition of the whole. A Gauss-Newton step
that is not exact still ends at the optimum, so the digits that this costs are not lost.

Source: Nocedal and Wright, Numerical Optimization (2006), ch. 10, for the trust region's damping.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError
from twin.identification.modal_response import Hold, ModalParameters, jacobian, respond
from twin.identification.spectra import Spectrum

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

MOST_STEPS = 60
STEEPEST = 1e8
"""Damping, in units of the scaled curvature, beyond which no step lowers the cost any more."""


@dataclass(frozen=True)
class Equations:
    """The linearised problem at one point.

    Attributes:
        cost: sum of squares of the whitened residual, twice counted: 2 e^H C^-1 e.
        gram: the Fisher information, (parameters, parameters).
        right: minus half the cost's gradient, (parameters,).
        white: whitened residual of all records, (lines * outputs of all,).
        kept: the first whitened derivatives, where they were asked for.
    """

    cost: float
    gram: Array
    right: Array
    white: ComplexArray
    kept: ComplexArray | None = None


def equations(
    p: ModalParameters,
    spectra: Sequence[Spectrum],
    whiten: Sequence[ComplexArray],
    hold: Hold,
    w_max: float,
    residual: bool,
    kept: int = 0,
) -> Equations:
    """Return Gauss-Newton's equations in the order of ``jacobian``, records one after the other.

    Args:
        p: where.
        spectra: the records.
        whiten: whitening matrices of each record, (lines, outputs, outputs).
        hold: what the input does between its samples.
        w_max: highest analysed angular frequency [rad/s].
        residual: whether the out-of-band term is part of the model.
        kept: how many of the first whitened derivatives to return.
    """
    own = [2 * len(p.omega) + edge.size for edge in p.edges]
    gram, right, common = np.zeros((0, 0)), np.zeros(0), 0
    white, first = [], []
    for i, (s, W) in enumerate(zip(spectra, whiten, strict=True)):
        J = jacobian(p, s, i, hold, w_max, residual)
        J = np.matmul(W, J).reshape(-1, J.shape[2])
        error = np.einsum("kij,kj->ki", W, s.Y - respond(p, s, i, hold, w_max)).ravel()
        if not i:
            common = J.shape[1] - own[0]
            gram = np.zeros((common + sum(own), common + sum(own)))
            right = np.zeros(len(gram))
        begin = common + sum(own[:i])
        at = np.r_[:common, begin : begin + own[i]]
        real = np.vstack([J.real, J.imag])
        gram[np.ix_(at, at)] += 2 * real.T @ real
        right[at] += 2 * real.T @ np.concatenate([error.real, error.imag])
        white.append(error)
        if kept:
            first.append(J[:, :kept])
    every = np.concatenate(white)
    cost = 2 * float(np.vdot(every, every).real)
    return Equations(cost, gram, right, every, np.vstack(first) if kept else None)


def cost_of(
    p: ModalParameters,
    spectra: Sequence[Spectrum],
    whiten: Sequence[ComplexArray],
    hold: Hold,
    w_max: float,
) -> float:
    """Return the cost alone, see ``Equations``."""
    cost = 0.0
    for i, (s, W) in enumerate(zip(spectra, whiten, strict=True)):
        error = np.einsum("kij,kj->ki", W, s.Y - respond(p, s, i, hold, w_max))
        cost += 2 * float(np.vdot(error, error).real)
    return cost


def least_squares(
    x: Array,
    linearised: Callable[[Array], Equations],
    cost: Callable[[Array], float],
    tolerance: float,
) -> Array:
    """Return where the cost is least (Levenberg and Marquardt).

    Args:
        x: where to start.
        linearised: the equations at a point.
        cost: the cost at a point.
        tolerance: squared distance from the optimum, in standard deviations, to end at.

    Raises:
        IdentificationError: the iteration diverged.
    """
    damping = 1e-4
    for _ in range(MOST_STEPS):
        here = linearised(x)
        size = np.sqrt(np.maximum(np.diag(here.gram), np.finfo(float).tiny))
        G, h = here.gram / np.outer(size, size), here.right / size
        if not (np.isfinite(here.cost) and np.all(np.isfinite(G))):
            raise IdentificationError("the maximum-likelihood fit diverged")
        moved = None
        while damping < STEEPEST:
            step = np.linalg.solve(G + damping * np.eye(len(G)), h)
            promised = float(step @ (2 * h - G @ step))
            if promised < tolerance:
                return x
            there = cost(x + step / size)
            if there < here.cost:
                moved = x + step / size
                good = (here.cost - there) > 0.5 * promised
                damping = max(damping / (100 if good else 2), 1e-14)
                break
            damping *= 8
        if moved is None:
            return x
        x = moved
    return x
