"""Least squares of a modal model with all that enters linearly eliminated (variable projection).

The output o of the modal model is linear in its shape components, direct terms and free ends:

    Y_o(k) = sum_i [ psi_oi a_i(k) + conj psi_oi a~_i(k) ] + (direct terms) U(k) + (free ends)
    a_i(k) = b_i(k) (L_i . U(k)) + c_is t_i(k)          in record s

so that only the poles and the drive v_i = (L_i, c_i), one of its components fixed at 1, are
unknowns of the Gauss-Newton iteration: two numbers a mode where one record has one input and no
transient, whatever the number of outputs.

Source: Golub and Pereyra 1973; Kaufman 1975 for the derivative.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from twin.errors import IdentificationError
from twin.identification.piecewise import by_runs
from twin.identification.projected import Projected, turn
from twin.identification.seminormal import least_squares, real_rows, triangle
from twin.identification.separable_terms import Drive, Terms

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def project(
    drive: Drive,
    terms: Terms,
    weight: Array | ComplexArray,
    derivative: bool = True,
    held: NDArray[np.intp] | None = None,
) -> Projected:
    """Solve for all linear parameters at a drive; with derivatives, Gauss-Newton's equations too.

    Args:
        drive: poles and participations.
        terms: the records and the terms beside the modes.
        weight: reciprocal standard deviation of every line and output, (lines, outputs), or a
            whitening matrix of every line, (lines, outputs, outputs).
        derivative: whether to return Gauss-Newton's equations.
        held: modes whose pole and drive are not unknowns; the equations are of the others.
    """
    n = len(drive.omega)
    E, slope, mirror, mirror_slope = terms.modal(drive.poles)
    a = np.einsum("knq,nq->kn", E, drive.v)
    m = np.einsum("knq,nq->kn", mirror, drive.v.conj())
    pairs = np.stack([a + m, 1j * (a - m)], axis=2).reshape(len(a), 2 * n)
    Phi = np.hstack([pairs, terms.direct()])
    moves, moving = None, np.setdiff1d(np.arange(n), [] if held is None else held)
    if derivative and len(moving):
        free = [np.flatnonzero(np.arange(terms.drives) != c) for c in drive.anchor]
        own = np.stack([E[:, i, free[i]] for i in moving], axis=1)
        other = np.stack([mirror[:, i, free[i]] for i in moving], axis=1)
        v = drive.v[moving]
        f = np.einsum("knq,nq->kn", slope[:, moving], v)[:, :, None]
        g = np.einsum("knq,nq->kn", mirror_slope[:, moving], v.conj())[:, :, None]
        f, g = np.concatenate([f, own], axis=2), np.concatenate([g, other], axis=2)
        moves = np.stack([f + g, 1j * (f - g)], axis=3).reshape(len(a), -1)
    if weight.ndim == 3:
        return _jointly(drive, terms.Y, Phi, moves, weight.astype(complex), moving)
    return _by_output(drive, terms.Y, Phi, moves, np.asarray(weight.real), moving)


def _by_output(
    drive: Drive,
    Y: ComplexArray,
    Phi: ComplexArray,
    moves: ComplexArray | None,
    weight: Array,
    moving: NDArray[np.intp],
) -> Projected:
    """Outputs whose noise is independent; those with proportional weights share one projection."""
    n = len(drive.omega)
    e = len(moving) * drive.v.shape[1]
    outputs = Y.shape[1]
    psi, direct = np.empty((outputs, n), complex), np.empty((Phi.shape[1] - 2 * n, outputs))
    error, cost, loss = np.empty_like(Y), 0.0, np.zeros(n)
    gram, right = np.zeros((2 * e, 2 * e)), np.zeros(2 * e)
    level = weight[0]
    form = weight / level
    alike = np.ptp(form, axis=1).max() < 1e-9
    if not alike:
        done = by_runs(drive, Y, Phi, moves, weight, moving)
        if done is not None:
            return done
    for group in [np.arange(outputs)] if alike else [np.array([o]) for o in range(outputs)]:
        w = form[:, group[:1]]
        A = real_rows(w * Phi)
        size = np.maximum(np.linalg.norm(A, axis=0), np.finfo(float).tiny)
        A /= size
        R = triangle(A)
        y = real_rows(w * Y[:, group]) * level[group]
        solved, left = least_squares(A, R, y)
        again, left = least_squares(A, R, left)
        solved += again
        cost += float(np.sum(left**2))
        c = solved / size[:, None] / level[group]
        psi[group] = (c[: 2 * n : 2] + 1j * c[1 : 2 * n : 2]).T
        direct[:, group] = c[2 * n :]
        error[:, group] = Y[:, group] - Phi @ c
        inverse = linalg.solve_triangular(R, np.eye(len(R)), check_finite=False)[: 2 * n]
        for i in range(n):
            at = slice(2 * i, 2 * i + 2)
            spread = inverse[at] @ inverse[at].T
            loss[i] += float(np.sum(solved[at] * np.linalg.solve(spread, solved[at])))
        if moves is None:
            continue
        _, F = least_squares(A, R, real_rows(w * moves))
        G = (F.T @ F).reshape(e, 2, e, 2)
        h = (F.T @ left).reshape(e, 2, len(group))
        T = turn(drive, psi[group] * level[group, None], moving).reshape(len(group), e, 2, 2)
        both = np.einsum("oiea,ojfb->iejfab", T, T, optimize=True)
        part = np.einsum("iejf,iejfab->iajb", G, both, optimize=True)
        gram += part.reshape(2 * e, 2 * e)
        right += np.einsum("oiea,ieo->ia", T, h).ravel()
    if moves is None:
        return Projected(cost, psi, direct, error, loss=loss)
    return Projected(cost, psi, direct, error, gram, right, loss)


def _jointly(
    drive: Drive,
    Y: ComplexArray,
    Phi: ComplexArray,
    moves: ComplexArray | None,
    W: ComplexArray,
    moving: NDArray[np.intp],
) -> Projected:
    """Outputs whose noise is correlated, through the noise of the inputs they share."""
    n = len(drive.omega)
    e = len(moving) * drive.v.shape[1]
    lines, outputs = Y.shape
    A = real_rows(np.einsum("kij,kp->kijp", W, Phi).reshape(lines * outputs, -1))
    size = np.maximum(np.linalg.norm(A, axis=0), np.finfo(float).tiny)
    A /= size
    R = triangle(A)
    y = real_rows(np.einsum("kij,kj->ki", W, Y).reshape(-1, 1))[:, 0]
    solved, left = least_squares(A, R, y)
    again, left = least_squares(A, R, left)
    solved += again
    c = (solved / size).reshape(outputs, -1).T
    psi = (c[: 2 * n : 2] + 1j * c[1 : 2 * n : 2]).T
    inverse = linalg.solve_triangular(R, np.eye(len(R)), check_finite=False)
    loss = np.zeros(n)
    for i in range(n):
        at = (np.arange(outputs)[:, None] * Phi.shape[1] + [2 * i, 2 * i + 1]).ravel()
        spread = inverse[at] @ inverse[at].T
        loss[i] = solved[at] @ np.linalg.solve(spread, solved[at])
    done = Projected(float(left @ left), psi, c[2 * n :], Y - Phi @ c, loss=loss)
    if moves is None:
        return done
    T = turn(drive, psi, moving).reshape(outputs, e, 2, 2)
    F = np.einsum("kie,oiea->koia", moves.reshape(lines, e, 2), T, optimize=True)
    J = real_rows(np.einsum("koj,kjp->kop", W, F.reshape(lines, outputs, -1)).reshape(-1, 2 * e))
    _, J = least_squares(A, R, J)
    return replace(done, gram=J.T @ J, right=J.T @ left)


def solve(
    drive: Drive,
    terms: Terms,
    weight: Array | ComplexArray,
    tolerance: float = 1e-8,
    most: int = 40,
    held: NDArray[np.intp] | None = None,
) -> tuple[Drive, Projected]:
    """Iterate to the least weighted sum of squares (Levenberg and Marquardt).

    Args:
        drive: where to start.
        terms: the records and the terms beside the modes.
        weight: as for ``project``.
        tolerance: relative fall of the cost below which the iteration ends.
        most: iterations at most.
        held: modes whose pole and drive stay what they are; their shapes are solved for.

    Raises:
        IdentificationError: more unknowns than data.
    """
    unknowns = (2 * len(drive.omega) + terms.direct().shape[1]) * terms.Y.shape[1] + drive.v.size
    if 2 * terms.Y.size <= 2 * unknowns:
        raise IdentificationError(
            f"{len(drive.omega)} modes have {unknowns} unknowns, too many for "
            f"{2 * terms.Y.size} data in the band"
        )
    drive = reanchored(drive, terms)
    here = project(drive, terms, weight, held=held)
    moving = np.setdiff1d(np.arange(len(drive.omega)), [] if held is None else held)
    if not len(moving):
        return drive, here
    damping = 1e-4
    for _ in range(most):
        assert here.gram is not None
        assert here.right is not None
        size = np.sqrt(np.maximum(np.diag(here.gram), 1e-12 * np.diag(here.gram).max()))
        G, h = here.gram / np.outer(size, size), here.right / size
        more = 8.0
        while damping < 1e8:
            step = np.linalg.solve(G + damping * np.eye(len(G)), h)
            if step @ (2 * h - G @ step) < tolerance * here.cost:
                return drive, here  # no step promises more than the tolerance
            whole = np.zeros((*drive.v.shape, 2))
            whole[moving] = (step / size).reshape(len(moving), -1, 2)
            tried = drive.moved(whole)
            there = project(tried, terms, weight, held=held)
            if there.cost < here.cost:
                break
            damping, more = damping * more, 4 * more
        else:
            return drive, here
        fall = (here.cost - there.cost) / here.cost
        drive, here, damping = tried, there, max(damping / 10, 1e-12)
        if fall < tolerance:
            break
    return drive, here


def reanchored(drive: Drive, terms: Terms) -> Drive:
    """Return the same drive with that component of every mode fixed that moves it most.

    A component that hardly moves a mode is no measure for the others: they would run away.
    """
    E, _, _, _ = terms.modal(drive.poles)
    anchor = np.argmax(np.sqrt(np.mean(np.abs(E) ** 2, axis=0)) * np.abs(drive.v), axis=1)
    v = drive.v / drive.v[np.arange(len(anchor)), anchor][:, None]
    return replace(drive, v=v, anchor=anchor.astype(np.int64))


def start_drive(poles: ComplexArray, terms: Terms, weight: Array) -> Drive:
    """Return a first drive for given poles: all residues by least squares, then rank one."""
    n, q, m = len(poles), terms.drives, terms.Y.shape[1]
    E, _, mirror, _ = terms.modal(poles)
    pairs = np.stack([E + mirror, 1j * (E - mirror)], axis=3).reshape(len(E), 2 * n * q)
    A = real_rows(np.hstack([pairs, terms.direct()]) * weight)
    size = np.maximum(np.linalg.norm(A, axis=0), np.finfo(float).tiny)
    power = np.sqrt(np.maximum(np.mean(np.abs(terms.Y) ** 2, axis=0), np.finfo(float).tiny))
    gram = (A / size).T @ (A / size) + 1e-9 * np.eye(A.shape[1])
    c = np.linalg.solve(gram, (A / size).T @ real_rows(terms.Y / power * weight)) / size[:, None]
    residues = (c[: 2 * n * q : 2] + 1j * c[1 : 2 * n * q : 2]).reshape(n, q, m)
    reach = np.sqrt(np.mean(np.abs(E) ** 2, axis=0)) + np.finfo(float).tiny
    v, anchor = np.empty((n, q), complex), np.empty(n, np.int64)
    for i in range(n):
        left, _, _ = np.linalg.svd(residues[i] * reach[i][:, None], full_matrices=False)
        anchor[i] = int(np.argmax(np.abs(left[:, 0])))
        v[i] = left[:, 0] / reach[i]
        v[i] /= v[i, anchor[i]]
    omega = np.abs(poles)
    return Drive(omega, np.clip(-poles.real / omega, 1e-5, 0.9), v, anchor)
