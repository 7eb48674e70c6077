"""What laws do on the average of one recording's motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from twin.estimation.kalman import EquivalentLinear
from twin.estimation.system import Noise, Sampled, System, deviating

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Start:
    """The state before the first sample with the greatest posterior.

    Attributes:
        state: (n,).
        odds: what the log likelihood of the samples beside it lacks of their likelihood beside any,
            by Laplace's method: -1/2 x^T P^-1 x - 1/2 log det (1 + P H) with H its information.
        slopes: of the first whitened innovations with respect to deviations of the prior,
            (values, k), where it was found.
    """

    state: Array
    odds: float
    slopes: Array


@dataclass(frozen=True)
class LawAverages:
    """What laws do on the average of one recording's motion; of a linear model nothing.

    Attributes:
        equivalent: what they add to the linear system, for the gains.
        blur: variances of the outputs beside their noise's, (samples, m).
        slopes: k and c of each law's k d + c v, (l, 2); none where they are not known. Where laws
            are simulated, of deviations from the simulation.
        share: of the laws' own dashpots that these are, where laws are simulated.
        start: state that laws are simulated from, or follow the motion from, (n,); any without.
        start_odds: what such a start adds to the log likelihood of what follows [nat].
        start_slopes: of the first innovations with respect to it (``Start.slopes``).
        kicks: by sample, how much less certain blows, of hammers or at stops, leave the state
            before it, (n, n).
        acting: forces of the laws, (samples, l), where some are off while they act.
        errors: by what shares these are, (l,).
    """

    equivalent: EquivalentLinear | None = None
    blur: Array | None = None
    slopes: Array | None = None
    share: float = 0.0
    start: Array | None = None
    start_odds: float = 0.0
    start_slopes: Array | None = None
    kicks: Mapping[int, Array] = field(default_factory=dict)
    acting: Array | None = None
    errors: tuple[float, ...] = ()

    def tangent(self, system: System) -> Array:
        """Return what the laws do on the average, as forces of a system's state, (l, n)."""
        if self.slopes is None:
            return np.zeros_like(system.drift)
        return np.asarray(self.slopes[:, :1] * system.drift + self.slopes[:, 1:] * system.rate)

    def may_begin(self, system: System) -> bool:
        """Return whether laws of this system, simulated or following, may begin where these did."""
        alike = self.slopes is None or self.slopes.shape[0] == len(system.drift)
        return alike and self.start is not None and len(self.start) == len(system.A)

    def beginning(self, noise: Noise) -> Noise:
        """Return noise levels of a filter that begins with the start, where one was estimated."""
        start = noise.start if self.start is None else 0 * noise.start
        return replace(noise, start=start, kicks=self.kicks)

    def begun(self, start: Start) -> LawAverages:
        """Return the same where laws begin with a state."""
        return replace(self, start=start.state, start_odds=start.odds, start_slopes=start.slopes)

    def filtering(self, plant: Sampled) -> Sampled:
        """Return the system of a Kalman filter: of deviations, where laws are simulated."""
        if plant.driven is None:
            return plant
        return deviating(plant, self.tangent(plant.system))


def both(one: Array | None, other: Array | None) -> Array | None:
    """Return the sum of variances, either of which there may not be."""
    if one is None or other is None:
        return other if one is None else one
    return one + other
