"""M, K and R that agree best with all modal parameters at once, in the metric of their errors.

Equation (41) uses each residue as it comes: a symmetric second-order model has fewer parameters
than the modal model, so the identified residues and the direct term contradict each other within
their errors. Minimum distance in the metric of the Fisher information settles that as maximum
likelihood on the structured model would, to first order, without a second look at the data.

Source: the principle of indirect estimation, Soderstrom and Stoica, System Identification (1989).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, optimize, stats

from twin.identification.maximum_likelihood import ModalFit, pack
from twin.place import split_channel
from twin.second_order import SecondOrderModel

Array = NDArray[np.float64]

STEP = 1e-3
EXACT = 1e-8
"""Relative error of a frequency below which data are noise-free and eq. (41) is exact."""


@dataclass(frozen=True)
class Structure:
    """A second-order model and how well it agrees with the modal fit it came from.

    Attributes:
        model: M, R and K.
        std: standard deviations of their entries, in the same form, or None.
        chance: probability that a structure of this kind disagrees with its modal fit by as much
            or more; a small one says that the structure is of another kind.
    """

    model: SecondOrderModel
    std: SecondOrderModel | None
    chance: float


def structured_second_order(
    start: SecondOrderModel,
    fit: ModalFit,
    outputs: Sequence[str],
    inputs: Sequence[str],
    dt: float,
) -> Structure:
    """Refine M, K and R against the modal fit they came from.

    Args:
        start: from eq. (41).
        fit: the maximum-likelihood modal fit.
        outputs: accelerations, one for each coordinate of ``start``.
        inputs: forces on coordinates of ``start``.
        dt: sampling interval [s].

    Returns:
        The refined matrices with their uncertainty. The start is returned unchanged, without
        one, where more is measured or driven than its coordinates, where the data are exact, and
        when the fit does not converge.
    """
    measured = [f"acc_{place}" for place in start.coordinates]
    if set(outputs) != set(measured) or any(_place(n) not in start.coordinates for n in inputs):
        return Structure(start, None, 1.0)
    rows = [start.coordinates.index(_place(name)) for name in outputs]
    columns = [start.coordinates.index(_place(name)) for name in inputs]
    p = fit.parameters.only(fit.measured)
    compared = _compared(fit)
    count = len(compared)
    target = pack(fit.parameters, fit.residual)[compared]
    weight = _root_of_inverse(fit.fisher_covariance[np.ix_(compared, compared)])
    rank = np.argsort(p.omega)
    if np.min(fit.modal_std(bound=True)[0][fit.measured] * 2 * np.pi / p.omega) < EXACT:
        return Structure(start, None, 1.0)
    try:
        build, unknowns = _modal_coordinates(start, fit)
    except np.linalg.LinAlgError:  # a mass matrix that is not positive definite
        return Structure(start, None, 0.0)

    def distance(x: Array) -> Array:
        model = build(x)
        poles, W = symmetric_modes(model)
        omega, zeta = np.abs(poles), -poles.real / np.abs(poles)
        psi, participation = np.empty_like(p.psi), np.empty_like(p.participation)
        for i, r in enumerate(rank):
            w = W[:, i]
            anchor = w[rows[p.anchor[r]]]
            psi[:, r] = w[rows] / anchor
            gain = poles[i] ** 2
            if fit.hold == "held":
                gain = gain * (np.exp(poles[i] * dt) - 1) / poles[i]
            participation[r] = gain * anchor * w[columns]
        order = np.argsort(rank)
        direct = np.asarray(np.linalg.inv(model.M))[np.ix_(rows, columns)]
        here = replace(
            p,
            omega=omega[order],
            zeta=zeta[order],
            psi=psi,
            participation=participation,
            D=direct,
            transient=p.transient[:0],
            edges=(),
        )
        return np.asarray(weight @ (pack(here, False)[:count] - target))

    def slope(x: Array) -> Array:
        steps = STEP * np.eye(len(x))
        return np.column_stack([(distance(x + h) - distance(x - h)) / (2 * STEP) for h in steps])

    try:
        found = optimize.least_squares(distance, np.zeros(unknowns), slope, method="lm")
    except (ValueError, np.linalg.LinAlgError):
        return Structure(start, None, 0.0)
    freedom = count - unknowns
    chance = float(stats.chi2.sf(2 * found.cost, freedom)) if freedom > 0 else 1.0
    return Structure(build(found.x), _spread(build, found.x, found.jac), chance)


def _compared(fit: ModalFit) -> NDArray[np.intp]:
    """Return which of the packed parameters a structure has to agree with.

    Those of the measured modes, and D. Beside a pole above the band D also holds what that pole
    adds at rest, which no sensor tells apart from the masses' share: then the modes alone.
    """
    m, n = fit.parameters.psi.shape
    r = fit.parameters.participation.shape[1]
    mode = np.repeat(np.tile(np.arange(n), 4), np.repeat([1, 1, 2 * (m - 1), 2 * r], n))
    own = np.flatnonzero(mode < fit.measured.stop)
    return own if fit.outside else np.arange(len(mode) + m * r)


def _spread(
    build: Callable[[Array], SecondOrderModel], x: Array, jacobian: Array
) -> SecondOrderModel:
    """Carry the covariance of the parameters over to the entries of M, R and K."""
    covariance = np.linalg.pinv(jacobian.T @ jacobian, hermitian=True)
    plus, minus = (
        [build(x + sign * STEP * unit) for unit in np.eye(len(x))] for sign in (1.0, -1.0)
    )
    std = {}
    for name in ("M", "R", "K"):
        up, down = (np.array([getattr(m, name) for m in models]) for models in (plus, minus))
        by = (up - down) / (2 * STEP)
        std[name] = np.sqrt(np.einsum("aij,ab,bij->ij", by, covariance, by))
    return SecondOrderModel(**std, coordinates=plus[0].coordinates)


def _modal_coordinates(
    start: SecondOrderModel, fit: ModalFit
) -> tuple[Callable[[Array], SecondOrderModel], int]:
    """Parametrise M = T'T, K = T' W^2 T, R = T' C T around ``start``; return builder and size.

    W holds the undamped frequencies, known a thousand times better than the masses: as parameters
    of their own they do not make the least-squares problem stiff.
    """
    n = len(start.M)
    stiffness, shapes = linalg.eigh(start.K, start.M)
    T0, omega0 = np.linalg.inv(shapes), np.sqrt(np.maximum(stiffness, 1e-12 * stiffness[-1]))
    damping0 = shapes.T @ start.R @ shapes
    upper = np.triu_indices(n)
    size = np.sqrt(np.abs(np.outer(np.diag(damping0), np.diag(damping0))))[upper] + 1e-6 * omega0[0]
    relative_std = np.sort(fit.modal_std(bound=True)[0][fit.measured])[0] * 2 * np.pi / omega0[-1]

    def build(x: Array) -> SecondOrderModel:
        omega = omega0 * np.exp(x[:n] * relative_std)
        T = (np.eye(n) + 0.01 * x[n : n + n * n].reshape(n, n)) @ T0
        C = np.zeros((n, n))
        C[upper] = damping0[upper] + 0.01 * size * x[n + n * n :]
        C = C + np.triu(C, 1).T
        return SecondOrderModel(
            T.T @ T, T.T @ C @ T, T.T @ np.diag(omega**2) @ T, start.coordinates
        )

    return build, n + n * n + n * (n + 1) // 2


def symmetric_modes(model: SecondOrderModel) -> tuple[Array, Array]:
    """Return poles and vectors w with displacement response sum of w w^T / (s - l) + conjugate.

    Returns:
        Poles with positive imaginary part, by magnitude, (n,), and W, (n, n).

    Raises:
        ValueError: a mode does not oscillate.
    """
    n = len(model.M)
    values, vectors = np.linalg.eig(model.state_matrix())
    keep = np.flatnonzero(values.imag > 0)
    if len(keep) != n:
        raise ValueError("a mode does not oscillate")
    keep = keep[np.argsort(np.abs(values[keep]))]
    poles, V = values[keep], vectors[:n, keep]
    scale = np.einsum("ir,ijr,jr->r", V, _slope(model, poles), V)
    return poles, np.asarray(V / np.sqrt(scale))


def _slope(model: SecondOrderModel, poles: Array) -> Array:
    """Derivative 2 l M + R of the dynamic stiffness at each pole, (n, n, n)."""
    return np.asarray(2 * poles * model.M[:, :, None] + model.R[:, :, None])


def _place(name: str) -> str:
    """Return the place of a frame's channel, or "" for a channel that is not at one."""
    channel = split_channel(name)
    return str(channel[1]) if channel else ""


def _root_of_inverse(covariance: Array) -> Array:
    """Return W with W^T W equal to the inverse of a covariance, scaled for conditioning."""
    std = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(std, std)
    values, vectors = linalg.eigh((correlation + correlation.T) / 2)
    values = np.maximum(values, 1e-13 * values[-1])
    return np.asarray((vectors / np.sqrt(values)).T / std)
