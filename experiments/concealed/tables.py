"""Tables of cases: what each conceals and what a diagnosis should say."""

from __future__ import annotations

from zlib import crc32

import numpy as np

from .mechanisms import NEAR, UNNAMED, VERDICT, Mechanism, places

TABLES = (
    "single", "none", "absorbed", "pairs", "outside", "near", "one_sensor", "ground",
    "three_storeys", "five_storeys",
)  # fmt: skip
"""Names of the chain's tables."""

STRUCTURES = ("portal", "rotated", "beam", "drive")
"""Names of the tables beyond the chain; see ``structures``."""

KNOWN = (*TABLES, *STRUCTURES)
"""Names of all tables."""

Combination = tuple[tuple[str, str], ...]
"""(mechanism, location) of every effect of a case; empty where nothing is concealed."""

ABSORBED = (
    "coulomb_friction", "clearance", "hysteresis", "stiffness_drift", "quadratic_drag",
    "appendage", "base_compliance", "sensor_gain", "sensor_delay",
)  # fmt: skip
"""What a calibration can take up: damping reads dry friction, drag and delays; stiffness reads
slip, play, drifting and the base; mass reads an appendage and gains."""

NOT_ABSORBED = (("quadratic_drag", "floor2"), ("sensor_gain", "force_floor1"))
"""Where a frame with other numbers takes up less than two fifths of it."""

_STOREYS, _CROSSED = ("storey1", "storey2"), ("storey2", "storey1")
_FLOORS, _SENSORS = ("floor1", "floor2"), ("acc_floor1", "acc_floor2")
MASKED = (
    ("coulomb_friction", _STOREYS, "bumper", _STOREYS),
    ("coulomb_friction", _STOREYS, "bumper", _CROSSED),
    ("coulomb_friction", _STOREYS, "cubic_stiffness", _STOREYS),
    ("coulomb_friction", _STOREYS, "clearance", _CROSSED),
    ("coulomb_friction", _STOREYS, "damping", _CROSSED),
    ("cubic_stiffness", _STOREYS, "sensor_delay", _SENSORS),
    ("bumper", _STOREYS, "sensor_clipping", _SENSORS),
    ("hysteresis", _STOREYS, "mass", _FLOORS),
    ("hysteresis", _CROSSED, "stiffness", _STOREYS),
    ("clearance", _STOREYS, "sensor_gain", _SENSORS),
    ("clearance", _STOREYS, "stiffness", _STOREYS),
    ("appendage", _FLOORS, "coulomb_friction", _CROSSED),
    ("appendage", _FLOORS, "mass", _FLOORS[::-1]),
    ("quadratic_drag", _FLOORS, "stiffness", _STOREYS),
    ("quadratic_drag", _FLOORS, "coulomb_friction", _STOREYS),
    ("quadratic_stiffness", _STOREYS, "cubic_stiffness", _STOREYS),
    ("stiffness_drift", _STOREYS, "cubic_stiffness", _CROSSED),
    ("base_compliance", ("ground", "ground"), "coulomb_friction", _STOREYS),
)
"""Pairs of which one masks the other, and their places two by two."""

_PREFIX = {"single": "case"}
_STREAM = {"single": 0, "none": 1}


def combinations(table: str, storeys: int = 2) -> tuple[Combination, ...]:
    """Return what the cases of a table conceal; a round goes through all of it."""
    if table == "none":
        return ((),)
    if table == "pairs":
        return _pairs()
    if table == "absorbed":
        every = [pair for pair in places(storeys)
                 if pair[0] in ABSORBED and pair not in NOT_ABSORBED]  # fmt: skip
    elif table in ("outside", "near"):
        names = UNNAMED if table == "outside" else NEAR
        every = [(name, f"storey{i + 1}") for name in names for i in range(storeys)]
    elif table == "one_sensor":
        every = [pair for pair in places(storeys) if pair[0] != "sensor_swap"]
    elif table == "ground":
        every = [pair for pair in places(storeys) if not _of_fixed_ground(*pair)]
    else:
        every = list(places(storeys))
    return tuple((pair,) for pair in every)


def _of_fixed_ground(name: str, place: str) -> bool:
    """Return whether an effect needs a force on a floor, or a ground that stands or is unknown.

    Drag belongs to them: on a shaken ground it would have to be said against which air.
    """
    return place == "ground" or place.startswith("force_") or name == "quadratic_drag"


def _pairs() -> tuple[Combination, ...]:
    """Return the pairs, each at two of its places: the same storey or floor, and another."""
    found = []
    for one, first, other, second in MASKED:
        found += [((one, a), (other, b)) for a, b in zip(first, second, strict=True)]
    return tuple(found)


def combination_of(table: str, number: int, seed: int, storeys: int = 2) -> Combination:
    """Return what a case conceals and where; each round goes through all, shuffled."""
    every = combinations(table, storeys)
    turn, position = divmod(number - 1, len(every))
    key = [seed, 77, turn] if table in _STREAM else [seed, 77, turn, crc32(table.encode())]
    return every[np.random.default_rng(key).permutation(len(every))[position]]


def stream(table: str) -> int:
    """Return the number that sets the random draws of a table apart from those of the others."""
    return _STREAM[table] if table in _STREAM else crc32(table.encode())


def case_name(number: int, table: str = "single") -> str:
    """Return the name of a case's folder: case_0007, none_0007, pairs_0007."""
    return f"{_PREFIX.get(table, table)}_{number:04d}"


def expected(table: str, effects: tuple[Mechanism, ...]) -> str:
    """Return the verdict that a case asks for: that of its first effect."""
    if table == "outside":
        return "unexplained"
    name = effects[0].name if effects else "none"
    return VERDICT.get(name, "missing_physics")
