"""Stabilisation diagram: which poles stay as the order of the realization grows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.identification.era import HankelFactors
from twin.modal import mac, poles_to_modal
from twin.state_space import StateSpace

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

FREQUENCY_TOLERANCE = 0.01
DAMPING_TOLERANCE = 0.15
LEAST_MAC = 0.95
LARGEST_DAMPING = 0.3
STEADY = frozenset(("frequency", "damping", "shape"))


@dataclass(frozen=True)
class StablePole:
    """One pole of one order in the stabilisation diagram.

    Attributes:
        order: of the realization the pole belongs to.
        pole: continuous-time pole with positive imaginary part [rad/s].
        shape: its mode shape at the outputs, (outputs,).
        stable: whether the order before has it too, in all that can be compared.
        steady: which of "frequency", "damping" and "shape" the order before has too, within 1 %,
            15 % and a MAC of 0.95; shapes are not known to every method.
    """

    order: int
    pole: complex
    shape: ComplexArray
    stable: bool
    steady: frozenset[str] = frozenset()

    @property
    def frequency_hz(self) -> float:
        """Natural frequency [Hz]."""
        return abs(self.pole) / (2 * np.pi)

    @property
    def damping_ratio(self) -> float:
        """Damping ratio."""
        return -self.pole.real / abs(self.pole)


def continuous_poles(model: StateSpace) -> tuple[ComplexArray, ComplexArray]:
    """Return a discrete model's oscillating poles [rad/s] and their shapes, by frequency.

    Returns:
        Poles with positive imaginary part, (modes,), and shapes at the outputs, (outputs, modes).
    """
    assert model.dt is not None
    values, vectors = np.linalg.eig(model.A)
    keep = np.flatnonzero((values.imag > 1e-9) & (np.abs(values) > 1e-3))
    poles = np.log(values[keep].astype(complex)) / model.dt
    order = np.argsort(np.abs(poles))
    return poles[order], np.asarray(model.C @ vectors[:, keep[order]], complex)


def stabilisation(
    hankel: HankelFactors, dt: float, inputs: int, orders: Sequence[int]
) -> list[StablePole]:
    """Return the poles of every order, marked stable or not; unphysical damping is left out."""
    found: list[StablePole] = []
    last: list[StablePole] = []
    for order in orders:
        if order > hankel.rank:
            break
        poles, shapes = continuous_poles(hankel.realize(order, dt, inputs))
        freq, damping = poles_to_modal(poles)
        now = []
        for i in np.flatnonzero((damping > 0) & (damping < LARGEST_DAMPING)):
            shape = shapes[:, i]
            steady = max(
                (_shared(float(freq[i]), float(damping[i]), shape, old) for old in last),
                key=len,
                default=frozenset[str](),
            )
            now.append(StablePole(order, complex(poles[i]), shape, steady == STEADY, steady))
        found += now
        last = now
    return found


def _shared(freq: float, damping: float, shape: ComplexArray, old: StablePole) -> frozenset[str]:
    """Return what a pole has in common with one of the order before; nothing far from it."""
    if abs(freq / old.frequency_hz - 1) >= FREQUENCY_TOLERANCE:
        return frozenset()
    shared = {"frequency"}
    if abs(damping / old.damping_ratio - 1) < DAMPING_TOLERANCE:
        shared.add("damping")
    if mac(shape[:, None], old.shape[:, None])[0, 0] > LEAST_MAC:
        shared.add("shape")
    return frozenset(shared)


def persistent_columns(
    diagram: Sequence[StablePole], least_share: float = 0.4
) -> list[list[StablePole]]:
    """Return the columns of stable poles that enough of the orders share, highest order first.

    Args:
        diagram: all poles of all orders.
        least_share: share of the orders in which a column must be stable.
    """
    orders = {p.order for p in diagram}
    stable = sorted((p for p in diagram if p.stable), key=lambda p: -p.order)
    columns: list[list[StablePole]] = []
    for pole in stable:
        for column in columns:
            near = abs(pole.frequency_hz / column[0].frequency_hz - 1) < 2 * FREQUENCY_TOLERANCE
            alike = mac(pole.shape[:, None], column[0].shape[:, None])[0, 0] > LEAST_MAC
            if near and alike:
                column.append(pole)
                break
        else:
            columns.append([pole])
    least = max(least_share * len(orders), 2)
    return [column for column in columns if len({p.order for p in column}) >= least]


def persistent_poles(diagram: Sequence[StablePole], least_share: float = 0.4) -> ComplexArray:
    """Return the pole of the highest order of each persistent column, by frequency, (modes,).

    Args:
        diagram: all poles of all orders.
        least_share: share of the orders in which a column must be stable.
    """
    kept = [column[0].pole for column in persistent_columns(diagram, least_share)]
    return np.array(sorted(kept, key=abs), complex)
