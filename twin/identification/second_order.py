"""Mass, stiffness and damping matrices from an identified modal model, eq. (41)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError
from twin.place import split_channel
from twin.second_order import SecondOrderModel

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def second_order_from_poles(
    poles: ComplexArray,
    shapes: ComplexArray,
    participation: ComplexArray,
    outputs: Sequence[str],
    inputs: Sequence[str],
) -> SecondOrderModel:
    """Return M, K and R of eq. (41) from continuous-time accelerance residues.

    A symmetric structure answers a force at j with the displacement residue w_i w_j, so its
    acceleration residue psi_i L_j equals l^2 w_i w_j. One input that acts where an output is
    measured (a driving point) fixes the scale of w; several inputs fix it by least squares.
    Equation (41) then holds for any number of floors.

    Args:
        poles: with positive imaginary part [rad/s], (modes,).
        shapes: psi, (outputs, modes).
        participation: L, in (m/s^2)/N, (modes, inputs).
        outputs: accelerations, one for each coordinate.
        inputs: forces.

    Raises:
        IdentificationError: the recording does not determine the matrices; says why.
    """
    channels = [split_channel(name) for name in outputs]
    rows = [i for i, c in enumerate(channels) if c is not None and c[0] == "acc"]
    places = [str(channels[i][1]) for i in rows if channels[i] is not None]  # type: ignore[index]
    if len(poles) != len(rows):
        raise IdentificationError(
            f"M, K and R need as many modes as measured accelerations: {len(poles)} modes, "
            f"{len(rows)} accelerations"
        )
    acting = [split_channel(name) for name in inputs]
    pairs = [
        (rows[places.index(str(c[1]))], j)
        for j, c in enumerate(acting)
        if c is not None and c[0] == "force" and str(c[1]) in places
    ]
    if not pairs:
        raise IdentificationError(
            "M, K and R need a driving point: a force on a place whose acceleration is measured "
            f"(inputs {', '.join(inputs)}; accelerations at {', '.join(places)})"
        )
    W = np.empty((len(rows), len(poles)), complex)
    for r, pole in enumerate(poles):
        # w_i = a psi_i with a^2 psi_j = L_j / l^2 at every driving point j.
        psi = np.array([shapes[i, r] for i, _ in pairs])
        load = np.array([participation[r, j] for _, j in pairs]) / pole**2
        square = np.vdot(psi, load) / np.vdot(psi, psi)
        W[:, r] = np.sqrt(square) * shapes[rows, r]
    W_all, poles_all = np.hstack([W, W.conj()]), np.concatenate([poles, poles.conj()])

    def inverse(power: int) -> Array:
        product = np.real((W_all * poles_all**power) @ W_all.T)
        if np.linalg.cond(product) > 1e12:
            raise IdentificationError("M, K and R: the identified mode shapes are dependent")
        return np.asarray(np.linalg.inv(product), float)

    M, K = inverse(1), -inverse(-1)
    R = -np.real(M @ (W_all * poles_all**2) @ W_all.T @ M)
    return SecondOrderModel(_symmetric(M), _symmetric(R), _symmetric(K), tuple(places))


def _symmetric(matrix: Array) -> Array:
    return (matrix + matrix.T) / 2
