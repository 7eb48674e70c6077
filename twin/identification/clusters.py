"""Columns of stable poles in a stabilisation diagram, with their spread."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.identification.complex_frequency import Denominator
from twin.identification.stabilisation import (
    DAMPING_TOLERANCE,
    FREQUENCY_TOLERANCE,
    StablePole,
)

ComplexArray = NDArray[np.complex128]

NEAR = 0.5
"""Poles closer than this share of their half bandwidth are one pole seen twice."""

LEAST_ORDERS = 4
"""Orders in a row a column must have at least."""

BROAD = 0.2
"""Damping ratio above which a pole is a background, not a resonance."""


@dataclass(frozen=True)
class Cluster:
    """One column of the stabilisation diagram.

    Attributes:
        pole: median of its poles [rad/s].
        spread: standard deviation of its poles over the orders [rad/s].
        orders: number of orders that have it.
    """

    pole: complex
    spread: float
    orders: int


def diagram(equations: Denominator, orders: Sequence[int], resolution: float) -> list[StablePole]:
    """Return the poles of every order, marked stable where the order before has them too.

    Args:
        equations: of the common denominator.
        orders: rising.
        resolution: distance of the lines [rad/s]; a bandwidth below it cannot be told.
    """
    found: list[StablePole] = []
    last = np.zeros(0, complex)
    for order in orders:
        poles = equations.poles(order)
        poles = poles[-poles.real < BROAD * np.abs(poles)]
        for pole in poles:
            width = max(-pole.real, resolution / 2)
            nearest = last[np.argmin(np.abs(last - pole))] if len(last) else complex(np.inf)
            stable = bool(abs(nearest - pole) < NEAR * width)
            steady = _shared(pole, nearest) if stable else frozenset()
            found.append(StablePole(order, complex(pole), np.ones(1, complex), stable, steady))
        last = poles
    return found


def _shared(pole: complex, old: complex) -> frozenset[str]:
    """Return whether frequency and damping stay within the tolerances of any diagram."""
    shared = set()
    if abs(abs(pole) / abs(old) - 1) < FREQUENCY_TOLERANCE:
        shared.add("frequency")
        if abs(pole.real * abs(old) / (old.real * abs(pole)) - 1) < DAMPING_TOLERANCE:
            shared.add("damping")
    return frozenset(shared)


def clusters(poles: Sequence[StablePole], resolution: float) -> list[Cluster]:
    """Gather stable poles of successive orders into columns, by frequency."""
    columns: list[list[StablePole]] = []
    for pole in sorted((p for p in poles if p.stable), key=lambda p: -p.order):
        width = max(-pole.pole.real, resolution / 2)
        near = [c for c in columns if abs(c[-1].pole - pole.pole) < 2 * NEAR * width]
        if near:
            min(near, key=lambda c: abs(c[-1].pole - pole.pole)).append(pole)
        else:
            columns.append([pole])
    found = []
    for column in columns:
        if len({p.order for p in column}) < LEAST_ORDERS:
            continue
        values = np.array([p.pole for p in column])
        # The highest orders have the least bias.
        best = values[: max(len(values) // 2, 1)]
        middle = complex(np.median(best.real), np.median(best.imag))
        found.append(Cluster(middle, float(np.std(values)), len({p.order for p in column})))
    return sorted(found, key=lambda c: abs(c.pole))
