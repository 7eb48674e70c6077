"""A recording: uniformly sampled channels, virtual or real, always in SI units."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from twin.arrays import frozen
from twin.errors import RecordingError, available
from twin.place import split_channel
from twin.quantity import KIND_NAMES, OTHER, QUANTITIES
from twin.units import quantity_of, shown, si_factor, split_name

Array = NDArray[np.float64]

CHANNEL_HELP = (
    "force_ground, force_floorI, acc_ground, acc_floorI, disp_floorI, angle_pendulum, "
    "torque_pendulum"
)
"""The channels of a frame's storeys, whose names say what they measure."""

AXES = ("x", "y", "z")
"""What may stand behind the dot in the name of one axis of a vector sensor."""

GROUND = "acc_ground"
"""The acceleration of the ground, an input where nothing else drives the structure."""

_BRACKETS = re.compile(r"\[[^\[\]]*\]$")


@dataclass(frozen=True)
class Channel:
    """One measured quantity, named as the MJCF actuator or sensor it belongs to.

    >>> Channel("acc_floor1").unit
    'm/s^2'
    >>> Channel("tip.y", "acc").axis
    'y'

    Attributes:
        name: of the sensor or actuator, with ``.x``, ``.y`` or ``.z`` for one axis of a vector
            sensor; without an axis it is the x axis.
        kind: quantity, one of ``twin.quantity.QUANTITIES`` or "other"; the names of a frame's
            storeys ("acc_floor1") say it themselves.
        unit: SI unit; it follows from the kind unless that is "other".

    Raises:
        RecordingError: a name that no file can hold, no kind, or one that contradicts the name.
    """

    name: str
    kind: str = ""
    unit: str = ""

    def __post_init__(self) -> None:
        name = self.name
        if not name or not name.isprintable() or name != name.strip() or _BRACKETS.search(name):
            raise RecordingError(
                f"channel {ascii(name)[:60]}: a channel's name is not empty, printable, without "
                "spaces around it or a unit behind it"
            )
        if name == "time":
            raise RecordingError("channel 'time': that is the time axis, not a channel")
        implied = implied_kind(name)
        kind = self.kind or implied
        if kind is None:
            raise RecordingError(
                f"unknown channel '{name}': nothing says what it measures; write its unit behind "
                f"the name, as in '{name} [m/s^2]'. The names that need none are {CHANNEL_HELP}"
            )
        if implied and kind != implied:
            raise RecordingError(f"channel '{name}' is by its name no {KIND_NAMES.get(kind, kind)}")
        if kind not in QUANTITIES and kind != OTHER:
            raise RecordingError(
                f"channel '{name}': unknown kind '{kind}'; there are "
                f"{available([*QUANTITIES, OTHER])}"
            )
        unit = self.unit or (QUANTITIES[kind].unit if kind in QUANTITIES else "1")
        if kind in QUANTITIES and unit != QUANTITIES[kind].unit:
            raise RecordingError(f"channel '{name}': a {kind} is in {QUANTITIES[kind].unit}")
        object.__setattr__(self, "kind", kind)
        object.__setattr__(self, "unit", unit)

    @property
    def element(self) -> str:
        """Name of the MJCF sensor or actuator: the name without the axis."""
        return split_axis(self.name)[0]

    @property
    def axis(self) -> str:
        """One of x, y, z; "" where the name has none."""
        return split_axis(self.name)[1]

    @property
    def is_input(self) -> bool:
        """True for a force or a torque."""
        return self.kind in ("force", "torque")

    @property
    def title(self) -> str:
        """Name and unit, as a file's header has them: "acc_floor1 [m/s^2]"."""
        return f"{self.name} [{self.unit}]"


def split_axis(name: str) -> tuple[str, str]:
    """Split "tip.y" into ("tip", "y"); the axis is "" where the name has none."""
    element, dot, axis = name.rpartition(".")
    return (element, axis) if dot and element and axis in AXES else (name, "")


def implied_kind(name: str) -> str | None:
    """Return the kind that a name of a frame's storeys says ("acc_floor1"), or None."""
    parts = split_channel(split_axis(name)[0])
    return parts[0] if parts else None


def channel_in(name: str, unit: str, source: str) -> tuple[Channel, float]:
    """Return a channel as its name and unit say, and the factor that makes its values SI.

    Args:
        name: of the sensor or actuator.
        unit: as written between the brackets.
        source: what messages call it.

    Raises:
        RecordingError: an unknown unit, or one that contradicts the name.
    """
    where = f"{source}: column {shown(f'{name} [{unit}]')}"
    kind, base = implied_kind(name), ""
    if kind is not None:
        factor = si_factor(unit, kind, where)
    else:
        kind, base, factor = quantity_of(unit, where)
    try:
        return Channel(name, kind, base), factor
    except RecordingError as error:
        raise RecordingError(f"{source}: {error}") from None


def _bare(name: str) -> str:
    """Return a channel's name without ".x": both are the x axis of a vector sensor."""
    return name.removesuffix(".x") or name


@dataclass(frozen=True)
class Recording:
    """Uniformly sampled channels in SI units.

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
        axes = [_bare(name) for name in names]
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
        there = {_bare(name): index for index, name in enumerate(self.names)}
        missing = [name for name in names if _bare(name) not in there]
        if missing:
            raise RecordingError(
                f"{self.source}: no channel '{missing[0]}'; it has {available(self.names)}"
            )
        return [there[_bare(name)] for name in names]

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
