"""Tables of cases: what each conceals, what the diagnosis is told and what it should say."""

from __future__ import annotations

from typing import Any
from zlib import crc32

import numpy as np

from .mechanisms import VERDICT, Mechanism, places

TABLES = ("single", "none")
"""Names of the tables."""

Combination = tuple[tuple[str, str], ...]
"""(mechanism, location) of every effect of a case; empty where nothing is concealed."""

_PREFIX = {"single": "case"}
_STREAM = {"single": 0, "none": 1}


def combinations(table: str, storeys: int = 2) -> tuple[Combination, ...]:
    """Return what the cases of a table conceal; a round goes through all of it."""
    if table == "none":
        return ((),)
    return tuple((pair,) for pair in places(storeys))


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


def model_of(truth: dict[str, Any]) -> str:
    """Return the model that the diagnosis of a case is told: a shipped one, or a file.

    A file's name is meant within the case's folder.
    """
    return str(truth["model"])
