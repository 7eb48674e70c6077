"""Draws of an identified model: what the truth may be, given what was identified."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.control.absorber import GROUND, DesignModel
from twin.identification.result import Identification

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Uncertainty:
    """How far off an identified model may be.

    Attributes:
        spread: the stiffness of each storey and the mass of each floor are off by up to this
            share, independently and uniformly.
        frequency: relative standard deviation of the natural frequencies.
        damping: relative standard deviation of the damping ratios.
    """

    spread: float = 0.05
    frequency: float = 0.0
    damping: float = 0.0

    @classmethod
    def of(cls, identification: Identification, spread: float = 0.05) -> Uncertainty:
        """Return the uncertainty that an identification states, of its least certain mode."""
        modal = identification.modal
        f_std, d_std = modal.natural_freq_std, modal.damping_ratio_std
        frequency = 0.0 if f_std is None else float(np.max(f_std / modal.natural_freq))
        damping = 0.0 if d_std is None else float(np.max(d_std / np.abs(modal.damping_ratio)))
        return cls(spread, frequency, damping)

    def drawn(self, model: DesignModel, rng: np.random.Generator) -> DesignModel:
        """Draw a model.

        Storeys are scaled in the coordinates of the drifts, floors in their own, both by
        congruence, so that the matrices stay symmetric and positive definite.
        """
        s, floors = model.structure, model.floors
        n = len(s.M)
        stiffness = 1 + self.spread * rng.uniform(-1, 1, len(floors))
        stiffness = stiffness * (1 + 2 * self.frequency * rng.standard_normal())
        mass = 1 + self.spread * rng.uniform(-1, 1, len(floors))
        damping = max(0.0, 1 + self.damping * rng.standard_normal())
        drift, by_storey, by_floor = np.eye(n), np.ones(n), np.ones(n)
        below = s.coordinates.index(GROUND) if GROUND in s.coordinates else None
        for storey, floor in enumerate(floors):
            index = model.index(floor)
            if below is not None:
                drift[index, below] = -1.0
            by_storey[index], by_floor[index] = stiffness[storey] ** 0.5, mass[storey] ** 0.5
            below = index
        scale = np.linalg.solve(drift, by_storey[:, None] * drift)
        load = model.load
        M = by_floor[:, None] * s.M * by_floor
        if load is not None:
            load = load * by_floor**2
        structure = replace(s, M=M, R=s.R * damping, K=scale.T @ s.K @ scale)
        return replace(model, structure=structure, load=load)
