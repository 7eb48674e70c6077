"""The design model: an identified frame with the pendulum hinged on its top floor, eqs. (54)-(58).

Where the excitation enters is not printed (the paper's T_e): a force on a floor or on the ground is
a force on that coordinate of the identified model, so that a shaker on the ground needs a model
identified on the released rig, the ground among its coordinates. On a shake table the known input
is the ground's acceleration instead, and displacements are relative to the ground.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.arrays import frozen
from twin.errors import ControlError, available
from twin.frame import Pendulum
from twin.second_order import SecondOrderModel
from twin.state_space import StateSpace

Array = NDArray[np.float64]

PENDULUM = "pendulum"
GROUND = "ground"
SHAKE_TABLE = "acc_ground"
GRAVITY = 9.81


def floors_of(model: SecondOrderModel) -> tuple[str, ...]:
    """Return the floors among the coordinates from the ground up: "floor1", "floor2", ..."""
    floors = [name for name in model.coordinates if name.startswith("floor")]
    return tuple(sorted(floors, key=lambda name: int(name[5:])))


def with_pendulum(
    frame: SecondOrderModel, pendulum: Pendulum, gravity: float = GRAVITY
) -> SecondOrderModel:
    """Return the frame with the pendulum on its top floor, eqs. (54)-(56).

    K_3 is printed as one number, m_3 g l, and read as the lower right entry of a (2, 2) matrix.

    Args:
        frame: identified M, R and K, coordinates floor1.. and, on a released rig, ground.
        pendulum: its data; ``inertia_about`` says which reading of I_zz,3 holds.
        gravity: [m/s^2].

    Raises:
        ControlError: the model has no floors or has a pendulum already.
    """
    floors = floors_of(frame)
    if not floors or PENDULUM in frame.coordinates:
        raise ControlError(
            "the design model needs a frame with floors and without pendulum; its coordinates are "
            f"{available(frame.coordinates)}"
        )
    n = len(frame.coordinates)
    ml = pendulum.mass * pendulum.centre_distance
    M, R, K = (np.pad(matrix, ((0, 1), (0, 1))) for matrix in (frame.M, frame.R, frame.K))
    B_3 = np.zeros((2, n + 1))
    B_3[0, frame.coordinates.index(floors[-1])] = B_3[1, n] = 1.0
    M_3 = np.array([[pendulum.mass, ml], [ml, pendulum.pivot_inertia]])
    M = M + B_3.T @ M_3 @ B_3
    K[n, n] = ml * gravity
    R[n, n] = pendulum.damping
    return SecondOrderModel(M, R, K, (*frame.coordinates, PENDULUM))


@dataclass(frozen=True)
class DesignModel:
    """What the controller believes in.

    Attributes:
        structure: M, R, K with the pendulum among the coordinates.
        known_input: what is measured of the excitation: "force_floor1" or "force_ground" by the
            load cell [N], or "acc_ground" on a shake table [m/s^2].
        load: T_e of the known input, (n,); None for the obvious one: a unit force on its place, or
            on a shake table the inertia of the floors, -M [1 .. 1 0], which leaves out the mass
            between ground and first floor (``of`` does not).

    Raises:
        ControlError: a pendulum, a floor or the place of the known input is lacking.

    Source: eqs. (54) and (58).
    """

    structure: SecondOrderModel
    known_input: str
    load: Array | None = None

    def __post_init__(self) -> None:
        if self.load is not None:
            object.__setattr__(self, "load", frozen(self.load, float))
        have = self.structure.coordinates
        needed = [PENDULUM, "floor1"]
        if self.known_input != SHAKE_TABLE:
            needed.append(self.known_input.removeprefix("force_"))
        missing = [name for name in needed if name not in have]
        if missing:
            raise ControlError(
                f"the design model for '{self.known_input}' lacks the coordinate "
                f"{', '.join(missing)}; it has {available(have)}"
            )
        if self.known_input == SHAKE_TABLE and GROUND in have:
            raise ControlError(
                "on a shake table the ground's motion is given: take the model of the clamped frame"
            )

    @classmethod
    def of(cls, structure: SecondOrderModel, known_input: str) -> DesignModel:
        """Return the design model; on a shake table a free ground is taken out of the structure."""
        coordinates = structure.coordinates
        if known_input != SHAKE_TABLE or GROUND not in coordinates:
            return cls(structure, known_input)
        moving = np.array([float(name != PENDULUM) for name in coordinates])
        keep = [i for i, name in enumerate(coordinates) if name != GROUND]
        M, R, K = (m[np.ix_(keep, keep)] for m in (structure.M, structure.R, structure.K))
        names = tuple(coordinates[i] for i in keep)
        load = -(structure.M @ moving)[keep]
        return cls(SecondOrderModel(M, R, K, names), known_input, load)

    @property
    def floors(self) -> tuple[str, ...]:
        """Floors from the ground up."""
        return floors_of(self.structure)

    @property
    def measurements(self) -> tuple[str, ...]:
        """Channels of y in (58): the floors' accelerations and the pendulum's angle."""
        return (*(f"acc_{floor}" for floor in self.floors), "angle_pendulum")

    def index(self, coordinate: str) -> int:
        """Return the position of a coordinate."""
        return self.structure.coordinates.index(coordinate)

    def displacements(self) -> Array:
        """Return the rows that read the floors' displacements from the state, (floors, 2n).

        Relative to the ground, where it moves: that is what strains the frame.
        """
        rows = np.zeros((len(self.floors), 2 * len(self.structure.M)))
        for row, floor in enumerate(self.floors):
            rows[row, self.index(floor)] = 1.0
        if GROUND in self.structure.coordinates:
            rows[:, self.index(GROUND)] = -1.0
        return rows

    def influence(self) -> Array:
        """Return T_e of the known input, (n,)."""
        if self.load is not None:
            return self.load
        column = np.zeros(len(self.structure.M))
        if self.known_input == SHAKE_TABLE:
            for floor in self.floors:
                column[self.index(floor)] = 1.0
            return np.asarray(-self.structure.M @ column)
        column[self.index(self.known_input.removeprefix("force_"))] = 1.0
        return column

    def continuous(self) -> StateSpace:
        """Return the continuous-time model; inputs [known input, torque], outputs (58).

        The state is [x, x'].
        """
        n = len(self.structure.M)
        T = np.zeros((n, 2))
        T[:, 0] = self.influence()
        T[self.index(PENDULUM), 1] = 1.0
        A = self.structure.state_matrix()
        forced = np.linalg.solve(self.structure.M, T)
        floors = [self.index(floor) for floor in self.floors]
        angle = np.zeros((1, 2 * n))
        angle[0, self.index(PENDULUM)] = 1.0
        direct = np.vstack([forced[floors], np.zeros((1, 2))])
        if self.known_input == SHAKE_TABLE:
            direct[: len(floors), 0] += 1.0
        B = np.vstack([np.zeros((n, 2)), forced])
        return StateSpace(A, B, np.vstack([A[n:][floors], angle]), direct, None)
