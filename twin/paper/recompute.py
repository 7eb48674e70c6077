"""The paper's formulas as functions, and its models built from the printed numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from twin.identification.proportional_damping import proportional_damping
from twin.paper import printed
from twin.paper.printed import Array, symmetric, upper, values
from twin.second_order import SecondOrderModel

ComplexArray = NDArray[np.complex128]
FLOORS = ("floor1", "floor2")
INPUTS = 1
"""r of the hammer test: one force."""
OUTPUTS = 2
"""m of the hammer test: two accelerations."""


def storey_stiffness(beams: int = 2) -> float:
    """Return 12 E J / L^3 [N/m] of a clamped-clamped beam times the beams in parallel, eq. (7)."""
    E, J = printed.YOUNG_MODULUS.value, printed.SECOND_MOMENT.value
    return beams * 12 * E * J / printed.BEAM_LENGTH.value**3


def lumped_model(stiffness: float | None = None) -> SecondOrderModel:
    """Return the undamped two-storey model of (2)-(7); ``stiffness`` [N/m] replaces (7)'s k."""
    k = storey_stiffness() if stiffness is None else stiffness
    K = np.array([[2 * k, -k], [-k, k]])
    return SecondOrderModel(np.diag(values(printed.MASS)), np.zeros((2, 2)), K, FLOORS)


def identified_model(damping: tuple[printed.Printed, ...] | None = None) -> SecondOrderModel:
    """Return (50)-(51) with the printed damping matrix given, (53) unless told."""
    R = values(damping or printed.IMPROVED_DAMPING_MATRIX)
    M, K = values(printed.MASS_MATRIX), values(printed.STIFFNESS_MATRIX)
    return SecondOrderModel(symmetric(M), symmetric(R), symmetric(K), FLOORS)


def undamped_frequencies(entries: Array) -> Array:
    """Return the natural frequencies [Hz], (2,), of M and K given as (M11, M12, M22, K11, ..)."""
    stiffness = linalg.eigvalsh(symmetric(entries[3:6]), symmetric(entries[:3]))
    return np.asarray(np.sqrt(stiffness) / (2 * np.pi))


def real_shapes(model: SecondOrderModel) -> Array:
    """Return the undamped shapes with the first floor scaled to 1, (2, 2), one column a mode."""
    shapes = np.real(model.undamped_modes().mode_shape)
    return np.asarray(shapes / shapes[0])


def printed_shapes(amplitude: Array, phase: Array) -> ComplexArray:
    """Return the complex shapes e^(i Theta) rho of (8), floor 1 scaled to 1, (2, modes)."""
    return np.vstack([np.ones(len(amplitude)), amplitude * np.exp(1j * phase)])


def printed_poles(frequency_hz: Array, damping_ratio: Array) -> ComplexArray:
    """Return the poles [rad/s] with positive imaginary part, (modes,)."""
    omega = 2 * np.pi * frequency_hz
    return np.asarray(omega * (-damping_ratio + 1j * np.sqrt(1 - damping_ratio**2)))


def fitted_coefficients(modal: Array) -> Array:
    """Return (alpha, beta) of (42)-(45) for modal = (f1, f2, xi1, xi2, ..)."""
    return np.array(proportional_damping(modal[:2], modal[2:4]))


def proportional_matrix(coefficients: Array, matrices: Array) -> Array:
    """Return (46), alpha M + beta K, as (R11, R12, R22), from (M11, M12, M22, K11, K12, K22)."""
    return np.asarray(coefficients[0] * matrices[:3] + coefficients[1] * matrices[3:6])


def implied_coefficients(damping: Array, matrices: Array) -> tuple[Array, float]:
    """Return the (alpha, beta) that (46) needs for a damping matrix, and the largest residual.

    Least squares over the three entries (11, 12, 22) of R = alpha M + beta K.
    """
    columns = np.column_stack([matrices[:3], matrices[3:6]])
    coefficients = np.linalg.lstsq(columns / np.abs(columns).max(0), damping, rcond=None)[0]
    coefficients = coefficients / np.abs(columns).max(0)
    return coefficients, float(np.abs(columns @ coefficients - damping).max())


def normalised_eigenvectors(model: SecondOrderModel) -> tuple[ComplexArray, ComplexArray]:
    """Return (W, poles), (n, 2n) and (2n,), scaled as (41) needs them.

    With Phi = [W; W Lambda] the scale is Phi^T [[R, M], [M, 0]] Phi = I.
    """
    n = len(model.M)
    poles, vectors = np.linalg.eig(model.state_matrix())
    metric = np.block([[model.R, model.M], [model.M, np.zeros((n, n))]])
    size = np.einsum("ij,ik,kj->j", vectors, metric, vectors)
    return np.asarray(vectors[:n] / np.sqrt(size.astype(complex))), poles.astype(complex)


def matrices_of_eigenvectors(W: ComplexArray, poles: ComplexArray) -> tuple[Array, Array, Array]:
    """Return M, K, R by (41) as it is printed, whatever the scale of W."""
    M = np.linalg.inv(np.real(W * poles @ W.T))
    K = -np.linalg.inv(np.real(W / poles @ W.T))
    R = -M @ np.real(W * poles**2 @ W.T) @ M
    return np.asarray(M), np.asarray(K), np.asarray(R)


def eigenvectors_of_modal(modal: Array, scale: Array, sign: tuple[int, int]) -> ComplexArray:
    """Return W of (41), (2, 4), from the numbers of (47)-(48) and the scales of its columns.

    Args:
        modal: (f1, f2, xi1, xi2, rho1, rho2, Theta1, Theta2).
        scale: (Re s1, Im s1, Re s2, Im s2), where column j of W is sqrt(s_j) times the shape.
        sign: of each mode's phase; -1 takes the shape of the conjugate pole.
    """
    shapes = printed_shapes(modal[4:6], np.array(sign) * modal[6:8])
    W = shapes * np.sqrt(scale[0::2] + 1j * scale[1::2])
    return np.hstack([W, W.conj()])


def matrices_of_modal(modal: Array, scale: Array, sign: tuple[int, int]) -> Array:
    """Return (M11, M12, M22, K11, .., R22) by (41) from (47)-(48); see eigenvectors_of_modal."""
    poles = printed_poles(modal[:2], modal[2:4])
    W = eigenvectors_of_modal(modal, scale, sign)
    matrices = matrices_of_eigenvectors(W, np.concatenate([poles, poles.conj()]))
    return np.concatenate([upper(matrix) for matrix in matrices])


def absorber_model(inertia: float | None = None) -> SecondOrderModel:
    """Return the frame of (50), (51), (53) with the pendulum of (56) on floor 2, eqs. (54)-(56).

    Args:
        inertia: about the pendulum's centre of mass [kg m^2]; (56)'s I_zz,3 unless told.
    """
    m, half = printed.PENDULUM_MASS.value, printed.HALF_LENGTH.value
    about_centre = printed.PENDULUM_INERTIA.value if inertia is None else inertia
    frame = identified_model()
    M, R, K = (np.zeros((3, 3)) for _ in range(3))
    M[:2, :2], R[:2, :2], K[:2, :2] = frame.M, frame.R, frame.K
    M[1:, 1:] += [[m, m * half], [m * half, m * half**2 + about_centre]]
    K[2, 2] += m * printed.GRAVITY.value * half
    return SecondOrderModel(M, R, K, (*FLOORS, "pendulum"))
