"""Results that print as a short table, show as HTML in a notebook, draw and save themselves."""

from __future__ import annotations

import math
from collections.abc import Iterable
from html import escape
from importlib import import_module
from pathlib import Path
from typing import Any

LONGEST = 100
"""Letters of a cell that are printed; a notebook breaks lines by itself."""

LEFT = " style='text-align:left'"


class Presentable:
    """Base of the nouns and results of the public interface.

    What they can show is in ``twin.presenting``, which knows the rooms that draw and write; it is
    loaded when something is shown.
    """

    def _title(self) -> str:
        """Return what this is, in a line."""
        raise NotImplementedError

    def _rows(self) -> Iterable[tuple[str, str]]:
        """Return the lines of the table: what, and how much."""
        raise NotImplementedError

    def __repr__(self) -> str:
        """Return a short table."""
        rows = [(name, _short(value)) for name, value in self._rows()]
        width = max((len(name) for name, _ in rows), default=0)
        return "\n".join([self._title(), *(f"  {n:<{width}}  {v}".rstrip() for n, v in rows)])

    def _repr_html_(self) -> str:
        """Return the same table for a notebook, in full."""
        cells = "".join(
            f"<tr><th{LEFT}>{escape(name)}</th><td{LEFT}>{escape(value)}</td></tr>"
            for name, value in self._rows()
        )
        return f"<div><b>{escape(self._title())}</b><table>{cells}</table></div>"

    def plot(self) -> Any:
        """Return a Matplotlib figure of what is worth seeing first."""
        return import_module("twin.presenting").plot(self)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain Python, ready for JSON."""
        found: dict[str, Any] = import_module("twin.presenting").to_dict(self)
        return found

    def save(self, path: str | Path) -> Path:
        """Write this to a file, whole or not at all, and return its path.

        A recording in the format of the suffix; a twin as MJCF (.xml); a result as JSON (.json),
        identification and diagnosis also as HTML report (.html) and for Rerun (.rrd).

        Raises:
            TwinError: a suffix that this cannot be written as, or a failing disk.
        """
        written: Path = import_module("twin.presenting").save(self, Path(path))
        return written


def with_deviation(value: float, std: float) -> str:
    """Return "1.948840 ± 0.000041": two digits of the deviation, and as many of the value."""
    if not (math.isfinite(std) and std > 0):
        return f"{value:.6g}"
    decimals = max(1 - math.floor(math.log10(std)), 0)
    return f"{value:.{decimals}f} ± {std:.{decimals}f}"


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
