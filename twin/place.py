"""Names of places and channels, as the MJCF and the recordings use them."""

from __future__ import annotations

import re
from dataclasses import dataclass

_PLACE = re.compile(r"^(?:(ground|pendulum)|(floor|storey)([1-9][0-9]*))$")
_CHANNEL = re.compile(r"^(force|acc|disp|angle|torque)_(ground|pendulum|floor[1-9][0-9]*)$")


@dataclass(frozen=True, order=True)
class Place:
    """Where something is: ``kind`` is ground, floor, storey or pendulum; ``number`` from 1.

    Examples:
        >>> place = Place.parse("floor2")
        >>> place.kind, place.number, str(place)
        ('floor', 2, 'floor2')
    """

    kind: str
    number: int = 0

    @classmethod
    def parse(cls, name: str) -> Place:
        """Read "floor2" or "ground". Raises ValueError for anything else."""
        match = _PLACE.match(name)
        if not match:
            raise ValueError(f"'{name}' is no place; places are ground, floor1, storey1, pendulum")
        if match[1]:
            return cls(match[1])
        return cls(match[2], int(match[3]))

    def __str__(self) -> str:
        return f"{self.kind}{self.number}" if self.number else self.kind


def split_channel(name: str) -> tuple[str, Place] | None:
    """Return (kind, place) of a channel name such as "acc_floor1", or None if it is not one."""
    match = _CHANNEL.match(name)
    if not match:
        return None
    kind, place = match[1], Place.parse(match[2])
    on_pendulum = place.kind == "pendulum"
    return (kind, place) if on_pendulum == (kind in ("angle", "torque")) else None
