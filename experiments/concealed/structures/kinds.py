"""The tables of structures: which structure, which tests, and what their cases conceal."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from zlib import crc32

import numpy as np

from ..mechanisms import STOREY
from .frames import PORTAL, ROTATED, frame
from .plan import Kit
from .slender import beam, drive
from .structure import Structure

Pair = tuple[str, str]


@dataclass(frozen=True)
class Kind:
    """A table.

    Attributes:
        model: the shipped model that a diagnosis is given.
        assemble: the structure with factors by name.
        kit: its tests.
        round_: what twenty cases in a row conceal, shuffled: groups of ``places_of``.
        encoder: noise of a displacement channel over that of the others.
    """

    model: str
    assemble: Callable[[Mapping[str, float]], Structure]
    kit: Kit
    round_: tuple[str, ...]
    encoder: float = 1.0


def _round(**counts: int) -> tuple[str, ...]:
    return tuple(name for name, count in counts.items() for _ in range(count))


_FRAME_KIT = Kit((0.5, 20.0), (5.0, 40.0), (0.3, 3.0), axes=("x", "y"))
KINDS: dict[str, Kind] = {
    "portal": Kind(
        "portal_3d", lambda off: frame(PORTAL, off), _FRAME_KIT,
        _round(column=6, storey=4, mass=2, base=2, point=1, channel=1, two=2, nothing=2),
    ),
    "rotated": Kind(
        "rotated_sensors", lambda off: frame(ROTATED, off), _FRAME_KIT,
        _round(storey=9, mass=2, base=2, point=1, channel=2, two=2, nothing=2),
    ),
    "beam": Kind(
        "cantilever", beam,
        Kit((0.5, 30.0), (0.1, 1.0), (0.01, 0.1), axes=("x",), softness=4.0, substeps=2),
        _round(hinge=9, mass=2, base=2, point=2, channel=1, two=2, nothing=2),
    ),
    "drive": Kind(
        "drive", drive, Kit((0.0, 0.0), (0.0, 0.0), (0.0, 0.0), loop=(113e3, 4.2e3)),
        _round(slide=9, mass=3, point=3, channel=2, two=1, nothing=2), encoder=0.01,
    ),
}  # fmt: skip
"""The tables by name. The portal's round: effects at a column's axis or at a storey's direction or
twist, an eccentric mass, a base that gives in one direction, two at once, nothing."""

OF_SLIDE = ("coulomb_friction", "coulomb_friction", "damping", "cubic_stiffness", "bumper")
CHANNEL = ("sensor_gain", "sensor_delay", "sensor_polarity")


def group_of(table: str, number: int, seed: int) -> str:
    """Return which group a case's effects come from; each round goes through all, shuffled."""
    every = KINDS[table].round_
    turn, position = divmod(number - 1, len(every))
    rng = np.random.default_rng([seed, 78, turn, crc32(table.encode())])
    return every[rng.permutation(len(every))[position]]


def places_of(group: str, table: str, structure: Structure) -> list[Pair]:
    """Return the mechanisms and places of a group."""
    drifts = list(structure.drifts)
    if group == "column":
        return [(m, p) for p in drifts if "_column" in p for m in STOREY]
    if group in ("storey", "hinge"):
        return [(m, p) for p in drifts if "_column" not in p for m in STOREY]
    if group == "slide":
        return [(m, "slide") for m in OF_SLIDE]
    if group == "mass":
        loads = [name for name in structure.bodies if "_load" in name]
        return [("mass", name) for name in loads or structure.bodies]
    if group == "base":
        return [("base_compliance", f"ground.{axis}") for axis in structure.shaken]
    if group == "point":
        names = ["quadratic_drag", "unmeasured_force"] + ["appendage"] * (table != "drive")
        return [(m, p) for p in structure.motions for m in names]
    if group == "channel":
        names = [m for m in CHANNEL if table != "drive" or m != "sensor_polarity"]
        return [(m, c) for c in structure.sensors for m in names]
    return []


def draw_pairs(
    rng: np.random.Generator, group: str, table: str, structure: Structure
) -> tuple[Pair, ...]:
    """Draw mechanism and place of each effect of a case of that group."""
    if group == "nothing":
        return ()
    if group != "two":
        every = places_of(group, table, structure)
        return (every[rng.integers(len(every))],)
    groups = {g for g in KINDS[table].round_ if g not in ("two", "nothing", "base")}
    while True:
        first, second = rng.choice(sorted(groups), 2, replace=False)
        found = (*draw_pairs(rng, str(first), table, structure),
                 *draw_pairs(rng, str(second), table, structure))  # fmt: skip
        if found[0][0] != found[1][0]:
            return found
