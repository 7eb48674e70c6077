"""What a file offers before anything of it becomes a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError, TwinError
from twin.units import shown

Array = NDArray[np.float64]

LISTED = 12
"""How many of a file's columns an error message lists."""


@dataclass(frozen=True)
class Column:
    """One series of samples in a file.

    Attributes:
        name: as the file has it, without the unit.
        unit: as the file has it, or None.
        sampling_hz: where the format keeps a time axis with each series [Hz].
        start_s: time of the first sample on that axis [s].
        problem: why it cannot be used ("holds text, not numbers"), or None.
    """

    name: str
    unit: str | None = None
    sampling_hz: float | None = None
    start_s: float = 0.0
    problem: str | None = None

    @property
    def label(self) -> str:
        """Name and unit, as a message shows them."""
        return shown(self.name if self.unit is None else f"{self.name} [{self.unit}]")


@dataclass(frozen=True)
class Table:
    """A file's columns and a way to load some of them.

    Attributes:
        source: the file, as messages name it.
        columns: what it holds.
        load: returns the samples of the columns with these indices, a float array each.
        sampling_hz: rate that the file itself declares [Hz], or None.
        row: what the format calls one sample ("row" in a CSV file).
        first_row: number of the first sample's row, counted as an editor counts.
    """

    source: str
    columns: tuple[Column, ...]
    load: Callable[[Sequence[int]], list[Array]]
    sampling_hz: float | None = None
    row: str = "sample"
    first_row: int = 1

    def at(self, sample: int) -> str:
        """Return where a sample stands, for a message: "test.csv: row 17"."""
        return f"{self.source}: {self.row} {sample + self.first_row}"

    def listed(self) -> str:
        """Return the columns for the end of a message, the first dozen of many."""
        labels = [column.label for column in self.columns[:LISTED]]
        more = len(self.columns) - len(labels)
        return (", ".join(labels) or "nothing") + (f" and {more} more" if more else "")


def library(name: str, path: Path) -> Any:
    """Import the optional library that reads a format, or say how to install it."""
    try:
        return import_module(name)
    except ImportError:
        needed = name.split(".")[0]
        raise TwinError(
            f"{path}: {path.suffix} files need {needed}; pip install 'frame-twin[formats]'"
        ) from None


@contextmanager
def decoding(path: Path, what: str) -> Iterator[None]:
    """Turn whatever a reader of foreign bytes raises into one line that names the file."""
    try:
        with catch_warnings():
            simplefilter("ignore")
            yield
    except TwinError:
        raise
    except Exception as error:  # damaged files make the libraries raise anything at all
        reason = shown(" ".join(str(error).split()) or type(error).__name__)
        raise RecordingError(f"{path}: damaged, or no {what} file ({reason})") from None


def samples_of(values: Any, what: str) -> Array:
    """Return real numbers as a float vector. Raises RecordingError for anything else."""
    array = np.asarray(values)
    if array.dtype.kind not in "iubf":
        raise RecordingError(f"{what} does not hold real numbers")
    return array.astype(float).ravel()
