"""Trials: recordings laid beside the model that is to explain them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from twin.arrays import frozen
from twin.second_order import SecondOrderModel
from twin.signals.noise_floor import noise_floor

Array = NDArray[np.float64]

SHAKE_TABLE = "acc_ground"
"""The input of a recording without any force: the ground's acceleration."""

MOTOR = "torque_"
"""How the names of inputs begin that a controller gives: held from sample to sample, always."""


@dataclass(frozen=True)
class Trial:
    """One recording, its channels in the order that all trials of a diagnosis share.

    Attributes:
        name: the file it came from.
        sampling_hz: samples per second.
        inputs: names of the columns of ``u``; an input that a recording lacks is zero there.
        outputs: names of the columns of ``y``.
        u: measured inputs, (samples, r).
        y: measured outputs, (samples, m).
        input_noise: standard deviation of the noise in each input, (r,).
        output_noise: the same for the outputs, (m,).
        added_mass: place -> mass bolted on for this recording [kg].
        blurred: samples that laws are not compared with, (samples,); there ``y`` is a prediction.
    """

    name: str
    sampling_hz: float
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    u: Array
    y: Array
    input_noise: Array
    output_noise: Array
    added_mass: Mapping[str, float] = field(default_factory=dict)
    blurred: NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        for name in ("u", "y", "input_noise", "output_noise"):
            object.__setattr__(self, name, frozen(getattr(self, name), float))

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self.y)

    @property
    def columns(self) -> dict[str, Array]:
        """Every channel's samples by name."""
        both = dict(zip(self.inputs, self.u.T, strict=True))
        return both | dict(zip(self.outputs, self.y.T, strict=True))

    def with_columns(self, columns: Mapping[str, Array]) -> Trial:
        """Return the trial with other samples in the same channels."""
        u = np.column_stack([columns[name] for name in self.inputs])
        y = np.column_stack([columns[name] for name in self.outputs])
        return replace(self, u=u, y=y)

    def with_outputs(self, y: Array, blurred: NDArray[np.bool_] | None = None) -> Trial:
        """Return the trial with other outputs, (samples, m), some of which are not compared."""
        return replace(self, y=y, blurred=blurred)

    def base(self, model: SecondOrderModel) -> SecondOrderModel:
        """Return the model with this recording's added masses."""
        M = model.M.copy()
        for place, mass in self.added_mass.items():
            index = model.coordinates.index(place)
            M[index, index] += mass
        return replace(model, M=M)


def trial(
    name: str,
    sampling_hz: float,
    columns: Mapping[str, Array],
    inputs: Sequence[str],
    outputs: Sequence[str],
    added_mass: Mapping[str, float] | None = None,
) -> Trial:
    """Make a trial from named columns; the noise levels come from the data themselves."""
    length = len(next(iter(columns.values())))
    u = np.column_stack([columns.get(c, np.zeros(length)) for c in inputs])
    y = np.column_stack([columns[c] for c in outputs])
    noise_u, noise_y = (np.array([noise_floor(c) for c in table.T]) for table in (u, y))
    # a command is known as it was given; its steps are no noise
    noise_u[[name.startswith(MOTOR) for name in inputs]] = 0.0
    return Trial(
        name,
        sampling_hz,
        tuple(inputs),
        tuple(outputs),
        u,
        y,
        noise_u,
        noise_y,
        dict(added_mass or {}),
    )
