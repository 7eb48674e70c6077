"""A recording: uniformly sampled channels, virtual or real, always in SI units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from twin.arrays import frozen
from twin.errors import RecordingError, available
from twin.place import SI_UNIT, Place, split_channel

Array = NDArray[np.float64]

CHANNEL_HELP = (
    "force_ground, force_floorI, acc_ground, acc_floorI, disp_floorI, angle_pendulum, "
    "torque_pendulum"
)


@dataclass(frozen=True)
class Channel:
    """One measured quantity, named as the MJCF actuator or sensor it belongs to."""

    name: str

    def __post_init__(self) -> None:
        if split_channel(self.name) is None:
            raise RecordingError(f"unknown channel '{self.name}'; channels are {CHANNEL_HELP}")

    @property
    def kind(self) -> str:
        """One of force, acc, disp, angle, torque."""
        return self._parts[0]

    @property
    def place(self) -> Place:
        """Where it is measured."""
        return self._parts[1]

    @property
    def unit(self) -> str:
        """SI unit."""
        return SI_UNIT[self.kind]

    @property
    def is_input(self) -> bool:
        """True for a force or a torque."""
        return self.kind in ("force", "torque")

    @property
    def _parts(self) -> tuple[str, Place]:
        parts = split_channel(self.name)
        assert parts is not None
        return parts


@dataclass(frozen=True)
class Recording:
    """Uniformly sampled channels in SI units.

    Attributes:
        sampling_hz: sampling frequency [Hz].
        channels: what the columns of ``data`` are.
        data: samples in SI units, (samples, channels), finite, read-only.
        source: where it came from (a file's name), used in messages.
        start_s: time of the first sample [s].

    Raises:
        RecordingError: doubled channels, a wrong shape, or samples that are not finite.
    """

    sampling_hz: float
    channels: tuple[Channel, ...]
    data: Array
    source: str = "recording"
    start_s: float = 0.0
    notes: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        object.__setattr__(self, "data", frozen(self.data, float))
        if not (np.isfinite(self.sampling_hz) and self.sampling_hz > 0):
            raise RecordingError(f"{self.source}: the sampling rate must be positive")
        names = self.names
        for name in names:
            if names.count(name) > 1:
                raise RecordingError(f"{self.source}: channel '{name}' appears twice")
        if self.data.ndim != 2 or self.data.shape[1] != len(names):
            raise RecordingError(
                f"{self.source}: data of shape {self.data.shape} for {len(names)} channels"
            )
        bad = np.argwhere(~np.isfinite(self.data))
        if len(bad):
            row, column = bad[0]
            raise RecordingError(
                f"{self.source}: sample {row + 1} of channel '{names[column]}' is not finite"
            )

    @classmethod
    def build(
        cls,
        sampling_hz: float,
        columns: dict[str, Array],
        source: str = "recording",
        start_s: float = 0.0,
        notes: tuple[str, ...] = (),
    ) -> Recording:
        """Make a recording from named columns of equal length, in SI units."""
        channels = tuple(Channel(name) for name in columns)
        data = np.column_stack([np.asarray(c, float) for c in columns.values()])
        return cls(sampling_hz, channels, data, source, start_s, notes)

    @property
    def names(self) -> tuple[str, ...]:
        """Channel names, in the order of the columns."""
        return tuple(channel.name for channel in self.channels)

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self.data)

    @property
    def duration_s(self) -> float:
        """Samples over sampling rate [s]."""
        return self.samples / self.sampling_hz

    @property
    def time(self) -> Array:
        """Time of each sample [s]."""
        return self.start_s + np.arange(self.samples) / self.sampling_hz

    def column(self, name: str) -> Array:
        """Return one channel's samples. Raises RecordingError, listing what there is."""
        return self.matrix((name,))[:, 0]

    def matrix(self, names: Sequence[str]) -> Array:
        """Return the samples of several channels, (samples, len(names))."""
        missing = [name for name in names if name not in self.names]
        if missing:
            raise RecordingError(
                f"{self.source}: no channel '{missing[0]}'; it has {available(self.names)}"
            )
        return self.data[:, [self.names.index(name) for name in names]]

    @property
    def inputs(self) -> tuple[str, ...]:
        """The channels that drive the structure.

        Forces and torques that act; on a shake table (``acc_ground`` and no force) the ground's
        acceleration. A force that is zero throughout is no input.
        """
        forces = [c.name for c in self.channels if c.is_input and np.any(self.column(c.name))]
        if forces:
            return tuple(forces)
        has_force = any(c.kind == "force" for c in self.channels)
        return ("acc_ground",) if "acc_ground" in self.names and not has_force else ()

    @property
    def outputs(self) -> tuple[str, ...]:
        """The channels that respond."""
        inputs = self.inputs
        return tuple(c.name for c in self.channels if not c.is_input and c.name not in inputs)

    def select(self, names: Sequence[str]) -> Recording:
        """Return a recording of these channels only."""
        data = self.matrix(names)
        return replace(self, channels=tuple(Channel(n) for n in names), data=data)

    def trim(self, start: int, stop: int) -> Recording:
        """Return the samples [start, stop). Raises RecordingError if fewer than two are left."""
        data = self.data[start:stop]
        if len(data) < 2:
            raise RecordingError(f"{self.source}: nothing left between samples {start} and {stop}")
        return replace(self, data=data, start_s=self.start_s + start / self.sampling_hz)
