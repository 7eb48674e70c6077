"""Projection where noise levels are constant over runs of lines, as they are over segments.

Lines of one run enter the normal equations of every output in one proportion: their products are
formed once for all outputs and added up with each output's own weights. That is as much faster
than a decomposition for every output as there are outputs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from twin.identification.projected import Projected, turn
from twin.identification.seminormal import DEPENDENT, real_rows
from twin.identification.separable_terms import Drive

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

LEAST_LINES = 8.0
"""Lines in a run on the average below which it saves nothing."""


@dataclass(frozen=True)
class Run:
    """Lines of the same weights.

    Attributes:
        rows: their indices.
        weight: of the outputs, (outputs,).
    """

    rows: NDArray[np.intp]
    weight: Array


def runs(weight: Array) -> list[Run]:
    """Gather the lines whose weights are equal for every output; weight is (lines, outputs)."""
    starts = np.flatnonzero(np.r_[True, np.any(np.diff(weight, axis=0) != 0, axis=1)])
    found: dict[bytes, list[NDArray[np.intp]]] = {}
    for rows in np.split(np.arange(len(weight)), starts[1:]):
        found.setdefault(weight[rows[0]].tobytes(), []).append(rows)
    return [Run(np.concatenate(rows), weight[rows[0][0]]) for rows in found.values()]


def by_runs(
    drive: Drive,
    Y: ComplexArray,
    Phi: ComplexArray,
    moves: ComplexArray | None,
    weight: Array,
    moving: NDArray[np.intp],
) -> Projected | None:
    """Project for outputs whose noise is independent, and constant over runs of lines.

    The residual of a first solution is solved for once more, which gives back the digits that
    normal equations cost.

    Args:
        drive: poles and participations.
        Y: outputs, (lines, outputs).
        Phi: regressors of all outputs, (lines, columns).
        moves: derivatives of the modes' regressors, (lines, 2 e), or None.
        weight: reciprocal standard deviation of every line and output, (lines, outputs).
        moving: modes that move.

    Returns:
        None where lines of equal weights are few, or where the regressors nearly depend.
    """
    parts = runs(weight)
    if len(weight) < LEAST_LINES * len(parts):
        return None
    n, columns, outputs = len(drive.omega), Phi.shape[1], Y.shape[1]
    level = np.array([np.exp(np.mean(np.log(part.weight))) for part in parts])
    relative = np.array([part.weight for part in parts]) / level[:, None]
    both = Phi if moves is None else np.hstack([Phi, moves])
    size = np.sqrt(
        2 * sum(w**2 * np.sum(np.abs(both[part.rows]) ** 2, axis=0)
                for w, part in zip(level, parts, strict=True))
    )  # fmt: skip
    size = np.maximum(size, np.finfo(float).tiny)
    blocks = [w * real_rows(both[part.rows]) / size for w, part in zip(level, parts, strict=True)]
    grams = np.array([block.T @ block for block in blocks])
    share = relative**2

    def against(left: ComplexArray) -> Array:
        """Products of all regressors with what is left of each output, (columns, outputs)."""
        return np.asarray(
            sum((block.T @ (w * real_rows(left[part.rows]))) * s
                for block, w, part, s in zip(blocks, level, parts, share, strict=True))
        )  # fmt: skip

    gram_of = [np.tensordot(share[:, o], grams, axes=1) for o in range(outputs)]
    factors = []
    for G in gram_of:
        try:
            R = linalg.cholesky(G[:columns, :columns], check_finite=False)
        except np.linalg.LinAlgError:
            return None
        if np.min(np.diag(R) / np.sqrt(np.diag(G)[:columns])) < DEPENDENT:
            return None
        factors.append(R)
    solved, left = np.zeros((columns, outputs)), Y
    for _ in range(2):
        right = against(left)[:columns]
        for o, R in enumerate(factors):
            solved[:, o] += linalg.cho_solve((R, False), right[:, o], check_finite=False)
        c = solved / size[:columns, None]
        left = Y - Phi @ c
    psi = (c[: 2 * n : 2] + 1j * c[1 : 2 * n : 2]).T
    cost = 2 * float(np.sum(np.abs(weight * left) ** 2))
    loss = np.zeros(n)
    for o, R in enumerate(factors):
        inverse = linalg.solve_triangular(R, np.eye(columns), check_finite=False)[: 2 * n]
        for i in range(n):
            at = slice(2 * i, 2 * i + 2)
            spread = inverse[at] @ inverse[at].T
            loss[i] += float(solved[at, o] @ np.linalg.solve(spread, solved[at, o]))
    if moves is None:
        return Projected(cost, psi, c[2 * n :], left, loss=loss)
    e = moves.shape[1] // 2
    unit = size[columns:].reshape(e, 2)
    h = against(left)[columns:].reshape(e, 2, outputs)
    T = turn(drive, psi, moving).reshape(outputs, e, 2, 2) * unit[:, :, None]
    gram = np.zeros((e, 2, e, 2))
    for o, (G, R) in enumerate(zip(gram_of, factors, strict=True)):
        X = linalg.solve_triangular(R, G[:columns, columns:], trans="T", check_finite=False)
        F = (G[columns:, columns:] - X.T @ X).reshape(e, 2, e, 2)
        half = np.einsum("iejf,jfb->iejb", F, T[o])
        gram += np.einsum("iea,iejb->iajb", T[o], half)
    right = np.einsum("oiea,ieo->ia", T, h).ravel()
    return Projected(cost, psi, c[2 * n :], left, gram.reshape(2 * e, 2 * e), right, loss)
