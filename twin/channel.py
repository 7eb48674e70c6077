"""A channel: one measured quantity, with its name, its kind and its SI unit."""

from __future__ import annotations

import re
from dataclasses import dataclass

from twin.errors import RecordingError, available
from twin.place import split_channel
from twin.quantity import KIND_NAMES, OTHER, QUANTITIES
from twin.units import quantity_of, shown, si_factor

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

    Examples:
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


def bare(name: str) -> str:
    """Return a channel's name without ".x": both are the x axis of a vector sensor."""
    return name.removesuffix(".x") or name
