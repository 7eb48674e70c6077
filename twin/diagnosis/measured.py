"""One recording laid beside the twin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twin.arrays import frozen
from twin.model.geometry import Geometric

Array = NDArray[np.float64]
Load = tuple[tuple[str, float], ...]

NOISE_DEVIATION = 0.7
"""Prior deviation of a noise level's logarithm about what the channel's own samples say: a factor
of two either way."""


@dataclass(frozen=True)
class Measured:
    """One recording laid beside the twin.

    Attributes:
        name: the file it came from.
        u: measured inputs in the model's order, zero where not recorded, (samples, r).
        y: measured outputs in the model's order; NaN where a sample is left out, (samples, m).
        input_noise, output_noise: standard deviations that the samples themselves show, (r,), (m,).
        added_mass: body -> mass bolted on for this recording [kg].
        input_deviation: prior deviation of the logarithm of the inputs' noise levels.
        geometric: what large motion adds to linear equations, where that is seen.
        bands: frequency above which each input has no power, nor noise any more [Hz], inf where
            there is none; empty for inputs as they were measured.
    """

    name: str
    u: Array
    y: Array
    input_noise: Array
    output_noise: Array
    added_mass: Mapping[str, float] = field(default_factory=dict)
    input_deviation: float = NOISE_DEVIATION
    geometric: Geometric | None = None
    bands: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for name in ("u", "y", "input_noise", "output_noise"):
            object.__setattr__(self, name, frozen(getattr(self, name), float))

    @property
    def load(self) -> Load:
        """Bodies and masses bolted on [kg], by name."""
        return tuple(sorted(self.added_mass.items()))

    @cached_property
    def driven(self) -> NDArray[np.bool_]:
        """Which inputs are not zero throughout, (r,)."""
        return np.any(self.u, axis=0)

    def part(self, samples: slice) -> Measured:
        """Return a part of the samples."""
        more = self.geometric
        return replace(
            self, u=self.u[samples], y=self.y[samples],
            geometric=None if more is None else more.part(samples),
        )  # fmt: skip
