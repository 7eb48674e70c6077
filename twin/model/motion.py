"""A simulated motion: what every sensor reads, and how the joints move."""

from __future__ import annotations

from dataclasses import dataclass, field

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.arrays import frozen
from twin.errors import ModelError, available

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """A simulated motion; sample n belongs to t = n / rate_hz.

    Attributes:
        rate_hz: samples per second.
        columns: channel -> samples in SI units, (samples,): every named sensor, a vector sensor by
            axis ("A1.y"), by its bare name where it can move along x only ("acc_floor1").
        qpos: joint positions of ``model``, for viewers, (samples, nq).
        model: the compiled model that ``qpos`` belongs to.
        others: what vector sensors read by names that are no channels of their own: the bare name,
            axes across the motion.
    """

    rate_hz: float
    columns: dict[str, Array]
    qpos: Array
    model: mujoco.MjModel
    others: dict[str, Array] = field(default_factory=dict, repr=False)

    def __repr__(self) -> str:
        seconds = self.samples / self.rate_hz
        return f"Motion({seconds:.4g} s at {self.rate_hz:g} Hz: {', '.join(self.columns)})"

    def __post_init__(self) -> None:
        columns = {name: frozen(values, float) for name, values in self.columns.items()}
        object.__setattr__(self, "columns", columns)
        object.__setattr__(self, "qpos", frozen(self.qpos, float))

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self.qpos)

    def column(self, name: str) -> Array:
        """Return a channel; a vector sensor's bare name is its x axis.

        Raises:
            ModelError: there is no such channel; the message lists those there are.
        """
        for known in (name, f"{name}.x", name.removesuffix(".x")):
            if known in self.columns:
                return self.columns[known]
        if name in self.others:
            return self.others[name]
        raise ModelError(f"no channel '{name}'; there are {available(self.columns)}")
