"""A table of a plan's file, read key by key: what is wrong is told with the key's name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise
from math import isfinite
from typing import Any

from twin.errors import TwinError, available


class Fields:
    """A table whose keys are taken one by one; a key that nobody took is an error.

    Attributes:
        where: the file and the table, as a message begins ("plan.toml: recordings[2].").
    """

    def __init__(self, where: str, table: object, known: Iterable[str] = ()) -> None:
        self.where, self.known = where, tuple(known)
        if not isinstance(table, Mapping):
            raise TwinError(f"{where.rstrip('.')}: expected a table of keys, not {table!r}")
        self.table: Mapping[str, Any] = table
        for key in table:
            if self.known and key not in self.known:
                raise TwinError(f"{where}{key}: no such key; there are {available(self.known)}")

    def wrong(self, key: str, wanted: str) -> TwinError:
        """Return the error that a key's value is not what is wanted."""
        got = repr(self.table[key]) if key in self.table else "missing"
        return TwinError(f"{self.where}{key}: expected {wanted}, {_not(got)}")

    def positive(self, key: str, default: float | None = None, unit: str = "") -> float:
        """Return a number above zero. Raises TwinError: it is none, or missing without default."""
        value = self.table.get(key, default)
        wanted = f"a positive number{f' of {unit}' if unit else ''}"
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.wrong(key, wanted)
        if not (isfinite(value) and value > 0):
            raise self.wrong(key, wanted)
        return float(value)

    def count(self, key: str, default: int) -> int:
        """Return a whole number from 1. Raises TwinError: it is none."""
        value = self.table.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int) or value < 1:
            raise self.wrong(key, "a whole number from 1")
        return value

    def one_of(self, key: str, options: tuple[str, ...], default: str | None = None) -> str:
        """Return one of some words. Raises TwinError: it is none of them."""
        value = self.table.get(key, default)
        if value not in options:
            raise self.wrong(key, f"one of {available(options)}")
        return str(value)

    def names(self, key: str) -> tuple[str, ...]:
        """Return a list of names, or the one there is; none where the key is missing."""
        value = self.table.get(key, ())
        several = (value,) if isinstance(value, str) else value
        if not isinstance(several, list | tuple) or not all(isinstance(v, str) for v in several):
            raise self.wrong(key, "a name or a list of names")
        if len(set(several)) < len(several):
            raise self.wrong(key, "names that differ")
        return tuple(several)

    def numbers(self, key: str, count: int | None = None) -> tuple[float, ...]:
        """Return numbers that grow from above zero. Raises TwinError: they do not."""
        value = self.table[key]
        wanted = f"{count or 'some'} positive numbers, each larger than the one before"
        sound = isinstance(value, list | tuple) and len(value) > 0
        sound = sound and all(isinstance(v, int | float) and not isinstance(v, bool) for v in value)
        if not sound or (count is not None and len(value) != count):
            raise self.wrong(key, wanted)
        if not all(isfinite(v) for v in value) or value[0] <= 0:
            raise self.wrong(key, wanted)
        if any(b <= a for a, b in pairwise(value)):
            raise self.wrong(key, wanted)
        return tuple(float(v) for v in value)

    def tables(self, key: str) -> list[object]:
        """Return a list of tables with at least one. Raises TwinError: it is none."""
        value = self.table.get(key)
        if not isinstance(value, list) or not value:
            raise self.wrong(key, "a list of at least one table")
        return value

    def table_at(self, key: str) -> Mapping[str, Any]:
        """Return a table, empty where there is none. Raises TwinError: it is something else."""
        value = self.table.get(key, {})
        if not isinstance(value, Mapping):
            raise self.wrong(key, "a table of keys")
        return value


def _not(got: str) -> str:
    return "but it is missing" if got == "missing" else f"not {got}"
