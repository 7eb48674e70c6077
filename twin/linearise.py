"""Mass, damping and stiffness matrices of any MuJoCo model about its static equilibrium.

The places are those of a chain of storeys; ``twin.model.assembling`` serves any model.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.arrays import frozen
from twin.contract import floors_of, names_in, pendulum_dof
from twin.errors import ModelError
from twin.modal import ModalModel
from twin.model.rest import Reduced, derivative, equilibrium, settle, symmetric
from twin.second_order import SecondOrderModel

Array = NDArray[np.float64]

__all__ = ["Linearisation", "equilibrium", "linearise"]


@dataclass(frozen=True)
class Linearisation:
    """A model about its static equilibrium: q = equilibrium + basis y.

    Attributes:
        generalised: M, R, K in the generalised coordinates y ("y1", "y2", ...), (n, n).
        places: what the rows of ``shape`` are: "floor1".., "ground" if it can move, "pendulum",
            "appendage_floor1".. if something swings there.
        shape: displacement of the places [m; rad for the pendulum] for unit y, (places, n).
        equilibrium: joint positions at the static equilibrium, (nq,).
        basis: the freedoms that the equality constraints leave, (nv, n).
    """

    generalised: SecondOrderModel
    places: tuple[str, ...]
    shape: Array
    equilibrium: Array
    basis: Array

    def __post_init__(self) -> None:
        for name in ("shape", "equilibrium", "basis"):
            object.__setattr__(self, name, frozen(getattr(self, name), float))

    @property
    def condensed(self) -> bool:
        """True where the model has more freedoms than places (a hinge chain)."""
        return self.shape.shape[0] != self.shape.shape[1]

    def modes(self) -> ModalModel:
        """Return all damped modes, their shapes at the places."""
        return self._at_places(self.generalised.modes())

    def undamped_modes(self) -> ModalModel:
        """Return the modes of M and K alone, their shapes at the places."""
        return self._at_places(self.generalised.undamped_modes())

    def second_order(self) -> SecondOrderModel:
        """Return M, R, K in the coordinates of the places.

        Exact where there are as many freedoms as places. Where there are more, the others follow
        the places statically (Guyan's condensation): static stiffness stays exact, frequencies come
        out slightly high; ``modes()`` has the exact ones.

        Raises:
            ModelError: the places do not move independently, or fewer freedoms than places.
        """
        places, n = self.shape.shape
        if np.linalg.matrix_rank(self.shape) < places:
            raise ModelError(
                f"the model has {n} freedoms for the {places} places {', '.join(self.places)}: "
                "they do not move independently"
            )
        y = self.generalised
        if self.condensed:
            # min y'Ky subject to shape y = x; the saddle point also serves a frame that floats.
            zero = np.zeros((places, places))
            saddle = np.block([[y.K, self.shape.T], [self.shape, zero]])
            target = np.vstack([np.zeros((n, places)), np.eye(places)])
            T = np.linalg.solve(saddle, target)[:n]
        else:
            T = np.linalg.inv(self.shape)
        M, R, K = (symmetric(T.T @ matrix @ T) for matrix in (y.M, y.R, y.K))
        return SecondOrderModel(M, R, K, self.places)

    def _at_places(self, modes: ModalModel) -> ModalModel:
        shape = self.shape @ modes.mode_shape
        return ModalModel(modes.natural_freq, modes.damping_ratio, shape, self.places)


def _places(model: mujoco.MjModel, reduced: Reduced) -> tuple[tuple[str, ...], Array]:
    """Names of the places and their displacement for each freedom, (places, n)."""
    names, rows = [], []
    jacobian = np.zeros((3, model.nv))
    for name in (*floors_of(model), "ground"):
        body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
        if body < 0:
            continue
        mujoco.mj_jacBody(reduced.model, reduced.data, jacobian, None, body)
        row = jacobian[0] @ reduced.basis
        if name != "ground" or np.max(np.abs(row), initial=0.0) > 1e-9:
            names.append(name)
            rows.append(row)
    pendulum = pendulum_dof(model)
    if pendulum is not None:
        names.append("pendulum")
        rows.append(reduced.basis[pendulum])
    for name in names_in(model)["body"]:
        if name.startswith("appendage_floor"):
            body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
            mujoco.mj_jacBody(reduced.model, reduced.data, jacobian, None, body)
            names.append(name)
            rows.append(jacobian[0] @ reduced.basis)
    return tuple(names), np.array(rows).reshape(len(names), reduced.basis.shape[1])


def linearise(model: mujoco.MjModel) -> Linearisation:
    """Return M, R, K, modes and mode shapes of a model about its static equilibrium.

    Args:
        model: a compiled model; bodies floor1.., ground, the sensor ``angle_pendulum`` and bodies
            appendage_floor1.. are its places.

    Raises:
        ModelError: there is no equilibrium near the initial position, or nothing that moves.
    """
    if model.nv == 0:
        raise ModelError("the model has no joint: nothing moves")
    reduced = Reduced(model)
    if reduced.basis.shape[1] == 0:
        raise ModelError("the equality constraints leave nothing that moves")
    settle(reduced)
    n = reduced.basis.shape[1]
    K = symmetric(-derivative(reduced.force, n))
    R = symmetric(-derivative(reduced.force_at_speed, n))
    M = symmetric(reduced.mass())
    places, shape = _places(model, reduced)
    coordinates = tuple(f"y{number}" for number in range(1, n + 1))
    return Linearisation(
        SecondOrderModel(M, R, K, coordinates), places, shape, reduced.qpos, reduced.basis
    )
