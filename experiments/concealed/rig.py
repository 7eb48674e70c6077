"""A lumped frame of N storeys and its matrices, with one effect built in."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from .laws import BOUC_WEN, COULOMB, JENKINS, WIDTH
from .near_laws import DAHL, IWAN, LUGRE, SLIDERS, STRIBECK, fastest_of

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

MASS_SPREAD = 0.003
DAMPING_SPREAD = 0.02


@dataclass(frozen=True)
class Rig:
    """Floor masses [kg], storey stiffnesses [N/m] and modal damping ratios, from the bottom up.

    Attributes:
        masses: of the floors [kg].
        stiffnesses: of the storeys [N/m].
        damping_ratios: of the modes of the frame on a fixed ground.
        ground_mass: of the ground, where it can move [kg].
        model: the shipped model that a diagnosis is given.
    """

    masses: tuple[float, ...]
    stiffnesses: tuple[float, ...]
    damping_ratios: tuple[float, ...]
    ground_mass: float = 3.0
    model: str = "two_storey_lumped"

    @property
    def storeys(self) -> int:
        """Number of storeys."""
        return len(self.masses)

    @property
    def drifts(self) -> Array:
        """The matrix that takes floor displacements to drifts."""
        return np.eye(self.storeys) - np.eye(self.storeys, k=-1)

    @property
    def stiffness(self) -> Array:
        """K of the floors on a fixed ground [N/m]."""
        return self.drifts.T @ np.diag(self.stiffnesses) @ self.drifts

    @property
    def modes(self) -> tuple[Array, Array]:
        """Natural frequencies [rad/s] and mass-normalised shapes (columns)."""
        squares, shapes = eigh(self.stiffness, np.diag(self.masses))
        return np.sqrt(squares), shapes

    @property
    def damping(self) -> Array:
        """Modal damping of the floors on a fixed ground, M Phi diag(2 zeta w) Phi' M [N s/m]."""
        omega, shapes = self.modes
        spread = np.diag(self.masses) @ shapes
        return spread @ np.diag(2 * np.array(self.damping_ratios) * omega) @ spread.T

    def scattered(self, rng: np.random.Generator) -> Rig:
        """Return a rig as built: masses and stiffnesses off by 0.3 %, damping ratios by 2 %."""

        def off(values: tuple[float, ...], spread: float) -> tuple[float, ...]:
            return tuple(float(v) for v in values * (1 + spread * rng.standard_normal(len(values))))

        return Rig(
            off(self.masses, MASS_SPREAD),
            off(self.stiffnesses, MASS_SPREAD),
            off(self.damping_ratios, DAMPING_SPREAD),
            self.ground_mass,
            self.model,
        )

    def as_json(self) -> dict[str, Any]:
        """Return plain types."""
        return {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(self).items()}

    @classmethod
    def from_json(cls, entry: dict[str, Any]) -> Rig:
        """Undo ``as_json``."""
        return cls(
            tuple(entry["masses"]),
            tuple(entry["stiffnesses"]),
            tuple(entry["damping_ratios"]),
            entry["ground_mass"],
            entry["model"],
        )


TWO_STOREY = Rig((0.65, 1.55), (518.577777777778, 518.577777777778), (0.0118, 0.0039))
"""The nominal rig, that of the shipped model ``two_storey_lumped``."""


class System(NamedTuple):
    """What the integrator integrates: M a + C v + K q + laws = force, floors first.

    Attributes:
        mass: of each degree of freedom [kg].
        stiffness: (n, n) [N/m].
        damping: (n, n) [N s/m].
        laws: (laws, 3): code, the degree of freedom that the law pulls back, and the one that it
            pulls along, -1 for the fixed ground; at most one dry friction and one
            with inner states.
        parameters: of the laws, (laws, ``WIDTH``).
        seen: (floors, n): what accelerometers see of the displacements on top of the floors'
            accelerations (a ground acceleration that is kept as a degree of freedom).
        friction: which of the laws is dry friction, -1 for none.
        slip: which has inner states, behind displacements and velocities.
        aside: the degree of freedom of another axis that a CROSS_AXIS law is coupled to.
        inner: number of inner states.
        fastest: rate at which the fastest of the laws relaxes [1/s]; 0 where the grid follows.
    """

    mass: Array
    stiffness: Array
    damping: Array
    laws: Integers
    parameters: Array
    seen: Array
    friction: int = -1
    slip: int = -1
    aside: int = -1
    inner: int = 1
    fastest: float = 0.0

    def with_law(self, code: int, parameters: list[float], top: int, bottom: int) -> System:
        """Return the system with one more law between two degrees of freedom."""
        row = np.zeros((1, WIDTH))
        row[0, : len(parameters)] = parameters
        count = len(self.laws)
        inverse = 1 / self.mass[top] + (1 / self.mass[bottom] if bottom >= 0 else 0.0)
        return self._replace(
            laws=np.vstack([self.laws, [[code, top, bottom]]]),
            parameters=np.vstack([self.parameters, row]),
            friction=count if code in (COULOMB, STRIBECK) else self.friction,
            slip=count if code in (BOUC_WEN, JENKINS, DAHL, LUGRE, IWAN) else self.slip,
            inner=SLIDERS if code == IWAN else self.inner,
            fastest=max(self.fastest, fastest_of(code, parameters, float(inverse))),
        )

    @property
    def size(self) -> int:
        """Number of states."""
        return 2 * len(self.mass) + self.inner

    @property
    def floors(self) -> int:
        """Number of floors, the first degrees of freedom."""
        return len(self.seen)


def linear_system(rig: Rig) -> System:
    """Return the rig with nothing built in."""
    n = rig.storeys
    return System(
        np.array(rig.masses), rig.stiffness, rig.damping, np.zeros((0, 3), np.int64),
        np.zeros((0, WIDTH)), np.zeros((n, n)),
    )  # fmt: skip


def enlarged(system: System, mass: float, columns: Array, rows: Array | None = None) -> System:
    """Return the system with one more degree of freedom.

    Args:
        system: to enlarge.
        mass: of the new degree of freedom [kg].
        columns: (3, n + 1): its last column of stiffness, of damping, and of ``seen`` (floors,
            then zeros).
        rows: (2, n + 1): its last row of stiffness and damping; None for symmetry.
    """
    n = len(system.mass)
    rows = columns[:2] if rows is None else rows
    stiffness, damping = np.zeros((2, n + 1, n + 1))
    for whole, part, column, row in (
        (stiffness, system.stiffness, columns[0], rows[0]),
        (damping, system.damping, columns[1], rows[1]),
    ):
        whole[:n, :n] = part
        whole[:, n] = column
        whole[n, :] = row
    seen = np.column_stack([system.seen, columns[2][: system.floors]])
    return system._replace(
        mass=np.append(system.mass, mass), stiffness=stiffness, damping=damping, seen=seen
    )
