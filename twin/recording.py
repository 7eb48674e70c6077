"""A recording: uniformly sampled channels, virtual or real, always in SI units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from twin.arrays import frozen
from twin.channel import GROUND, Channel, bare, channel_in
from twin.errors import RecordingError, available
from twin.presentable import Presentable
from twin.units import split_name

Array = NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Recording(Presentable):
    """Uniformly sampled channels in SI units.

    Examples:
        >>> hit = Recording.build(4.0, {"force_floor1": [0.0, 8.0, 0.0], "acc_floor1": [0, 1, 2]})
        >>> hit.inputs, hit.outputs, hit.duration_s
        (('force_floor1',), ('acc_floor1',), 0.75)

    Attributes:
        sampling_hz: sampling frequency [Hz].
        channels: what the columns of ``data`` are; a bare name and the name with ``.x`` are one.
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
        axes = [bare(name) for name in names]
        for name, axis in zip(names, axes, strict=True):
            if axes.count(axis) > 1:
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
        columns: Mapping[str, ArrayLike],
        source: str = "recording",
        start_s: float = 0.0,
        notes: tuple[str, ...] = (),
        kinds: Mapping[str, str] | None = None,
    ) -> Recording:
        """Make a recording from named columns of equal length.

        Examples:
            >>> r = Recording.build(100.0, {"force_floor1": [0.0, 1.0], "A3 [g]": [0.0, 0.1]})
            >>> [channel.title for channel in r.channels]
            ['force_floor1 [N]', 'A3 [m/s^2]']

        Args:
            sampling_hz: sampling frequency [Hz].
            columns: name -> samples in SI units, (samples,); or "name [unit]" -> samples in
                that unit, which are converted.
            source: what messages call it.
            start_s: time of the first sample [s].
            notes: what was done to it.
            kinds: name -> kind, of names that do not say it themselves and have no unit.

        Raises:
            RecordingError: as the class; a name that says no quantity.
        """
        channels, samples = [], []
        for title, values in columns.items():
            name, unit = split_name(title)
            column = np.asarray(values, float)
            if unit is None:
                channels.append(Channel(name, (kinds or {}).get(name, "")))
            else:
                channel, factor = channel_in(name, unit, source)
                channels.append(channel)
                column = column * factor
            samples.append(column)
        lengths = {len(column): channel for column, channel in zip(samples, channels, strict=True)}
        if len(lengths) > 1:
            (one, a), (other, b), *_ = lengths.items()
            raise RecordingError(
                f"{source}: '{a.name}' has {one} samples and '{b.name}' has {other}"
            )
        data = np.column_stack(samples) if samples else np.empty((0, 0))
        return cls(sampling_hz, tuple(channels), data, source, start_s, notes)

    def _title(self) -> str:
        seconds = f"{self.samples} samples at {self.sampling_hz:.6g} Hz ({self.duration_s:.6g} s)"
        return f"{self.source}: {seconds}"

    def _rows(self) -> Iterator[tuple[str, str]]:
        inputs = self.inputs
        for channel in self.channels:
            role = "input" if channel.name in inputs else "output"
            rms = float(np.sqrt(np.mean(self.column(channel.name) ** 2)))
            yield channel.title, f"{role}, RMS {rms:.4g}"
        for note in self.notes:
            yield "note", note

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
        return self.data[:, self._columns(names)]

    def channel(self, name: str) -> Channel:
        """Return one channel's description. Raises RecordingError, listing what there is."""
        return self.channels[self._columns((name,))[0]]

    def _columns(self, names: Sequence[str]) -> list[int]:
        """Return the columns of channels; a name without axis is that of the x axis."""
        there = {bare(name): index for index, name in enumerate(self.names)}
        missing = [name for name in names if bare(name) not in there]
        if missing:
            raise RecordingError(
                f"{self.source}: no channel '{missing[0]}'; it has {available(self.names)}"
            )
        return [there[bare(name)] for name in names]

    @property
    def inputs(self) -> tuple[str, ...]:
        """The channels that drive the structure.

        Forces and torques that act; on a shake table (``acc_ground``, or its axes, and no force)
        the ground's acceleration. A force that is zero throughout is no input.
        """
        forces = [c.name for c in self.channels if c.is_input and np.any(self.column(c.name))]
        if forces:
            return tuple(forces)
        if any(c.kind == "force" for c in self.channels):
            return ()
        ground = [c.name for c in self.channels if c.element == GROUND]
        return tuple(name for name in ground if np.any(self.column(name))) or tuple(ground)

    @property
    def outputs(self) -> tuple[str, ...]:
        """The channels that respond."""
        inputs = self.inputs
        return tuple(c.name for c in self.channels if not c.is_input and c.name not in inputs)

    def select(self, names: Sequence[str]) -> Recording:
        """Return a recording of these channels only."""
        data = self.matrix(names)
        return replace(self, channels=tuple(self.channel(n) for n in names), data=data)

    def trim(self, start: int, stop: int) -> Recording:
        """Return the samples [start, stop). Raises RecordingError if fewer than two are left."""
        data = self.data[start:stop]
        if len(data) < 2:
            raise RecordingError(f"{self.source}: nothing left between samples {start} and {stop}")
        return replace(self, data=data, start_s=self.start_s + start / self.sampling_hz)
