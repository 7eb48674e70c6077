"""Equations that print no numbers, tried on a model whose answer is known."""

from __future__ import annotations

import numpy as np

from twin.paper.printed import Array
from twin.paper.recompute import identified_model, matrices_of_eigenvectors, normalised_eigenvectors
from twin.state_space import StateSpace

STEPS = 12


def _model() -> tuple[StateSpace, Array]:
    """Return the frame of (50), (51), (53) hit on floor 1, at 32 Hz, and some observer gain G."""
    model = identified_model().acceleration_response(("floor1",)).held(1 / 32)
    G = 1e-4 * np.array([[3.0, -2.0], [1.0, 4.0], [-5.0, 2.0], [2.0, 1.0]])
    return model, G


def _markov(A: Array, B: Array, C: Array, count: int) -> Array:
    """Return C A^(k-1) B for k = 1 .. count, (count, outputs, columns of B)."""
    blocks = []
    state = B
    for _ in range(count):
        blocks.append(C @ state)
        state = A @ state
    return np.array(blocks)


def markov_recovery_error(observer_sign: int = 1) -> tuple[float, float]:
    """Return the largest relative errors of (29) and of (30) on observer Markov parameters (22).

    Args:
        observer_sign: the sign of G with which the gain parameters C A^(k-1) G are compared; with
            (13)-(14) as printed it is +1.
    """
    model, G = _model()
    A_bar = model.A + G @ model.C
    first = _markov(A_bar, model.B + G @ model.D, model.C, STEPS)
    second = _markov(A_bar, G, model.C, STEPS)
    system, gain = [np.asarray(model.D)], list[Array]()
    for k in range(1, STEPS + 1):
        system.append(first[k - 1] - sum(second[j - 1] @ system[k - j] for j in range(1, k + 1)))
        earlier = sum((second[j - 1] @ gain[k - j - 1] for j in range(1, k)), np.zeros((2, 2)))
        gain.append(second[k - 1] - earlier)
    true_system = _markov(model.A, model.B, model.C, STEPS)
    true_gain = observer_sign * _markov(model.A, G, model.C, STEPS)
    return (
        float(np.abs(np.array(system[1:]) - true_system).max() / np.abs(true_system).max()),
        float(np.abs(np.array(gain) - true_gain).max() / np.abs(true_gain).max()),
    )


def realization_error(exponent: float) -> float:
    """Return the largest relative error of C A^(k-1) B after (38) with Sigma^exponent in B and C.

    (36) splits the Hankel matrix into observability times controllability matrix, R Sigma^(1/2)
    and Sigma^(1/2) S^T; the first blocks of these two are C and B.
    """
    model, _ = _model()
    markov = _markov(model.A, model.B, model.C, 2 * STEPS)
    hankel, shifted = (
        np.block([[markov[i + j + k] for j in range(STEPS)] for i in range(STEPS)]) for k in (0, 1)
    )
    R, sigma, St = np.linalg.svd(hankel)
    R, sigma, St = R[:, :4], sigma[:4], St[:4]
    A = (R.T @ shifted @ St.T) / np.sqrt(np.outer(sigma, sigma))
    B = sigma[:, None] ** exponent * St[:, :1]
    C = R[:2] * sigma**exponent
    found = _markov(A, B, C, STEPS)
    return float(np.abs(found - markov[:STEPS]).max() / np.abs(markov).max())


def second_order_recovery_error(normalised: bool) -> float:
    """Return the largest relative error of M, K, R by (41) from the model's own eigenvectors.

    Args:
        normalised: scale them as (41) needs; otherwise as (8) does, the first component 1.
    """
    model = identified_model()
    W, poles = normalised_eigenvectors(model)
    if not normalised:
        W = W / W[0]
    found = matrices_of_eigenvectors(W, poles)
    return max(
        float(np.abs(estimate - true).max() / np.abs(true).max())
        for estimate, true in zip(found, (model.M, model.K, model.R), strict=True)
    )
