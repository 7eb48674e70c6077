"""Options and output that the commands share."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table

from twin.errors import TwinError
from twin.files import check_folder, folder, write_whole
from twin.provenance import Provenance, provenance

if TYPE_CHECKING:
    from twin.view.live import Live

Out = Annotated[
    Path | None, typer.Option("--out", metavar="DIR", help="Folder for the files it writes.")
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Same seed, same result, bit for bit.")]
Json = Annotated[
    str | None,
    typer.Option("--json", metavar="FILE", help="Write the result as JSON; - for standard output."),
]
Rerun = Annotated[
    bool, typer.Option("--rerun", help="Show the work in the Rerun viewer while it is done.")
]


WIDEST = 1000
"""Letters of the widest table."""


_given: list[str] = []
"""The arguments of the command that runs."""


__all__ = [
    "Json",
    "Out",
    "Rerun",
    "Seed",
    "check_folder",
    "check_json_target",
    "console",
    "folder",
    "keep_input",
    "made",
    "refuse_doubles",
    "remember",
    "watched",
    "write_json",
    "write_whole",
]


def remember(arguments: Sequence[str]) -> None:
    """Keep the command's arguments for the provenance of what it writes."""
    _given[:] = arguments


def made(files: Iterable[str | Path], seed: int | None) -> Provenance:
    """Return the provenance of what the command that runs writes, shipped models as their files."""
    from twin.model_files import shipped, shipped_names

    there = {name: str(shipped(name)) for name in shipped_names() if not Path(name).is_file()}
    origin = provenance(_given, [there.get(str(file), file) for file in files], seed)
    labels = {path: f"{name} (of the package)" for name, path in there.items()}
    return replace(origin, files=tuple((labels.get(f, f), digest) for f, digest in origin.files))


class Terminal(Console):
    """A console that never cuts a table's digits off: a table wider than it runs over its edge."""

    def print(self, *objects: Any, **options: Any) -> None:
        """Print as Console does, tables as wide as they are."""
        for table in (thing for thing in objects if isinstance(thing, Table)):
            if isinstance(table.title, str) and "\n" not in table.title:
                # a title wraps at its table's width: on a line of its own it has the terminal's
                super().print(table.title, style="table.title")
                table.title = None
            room = self.options.update(width=WIDEST)
            needed = Measurement.get(self, room, table).maximum
            if needed > self.width and all(column.no_wrap for column in table.columns):
                kept, self.width = self.width, needed
                try:
                    super().print(*objects, **options)
                finally:
                    self.width = kept
                return
        super().print(*objects, **options)


def console(json_target: str | None) -> Console:
    """Return the console for people: standard error when standard output carries JSON."""
    return Terminal(stderr=json_target == "-", highlight=False, soft_wrap=False)


def watched(wanted: bool) -> AbstractContextManager[Live | None]:
    """Return a viewer to show the work in, for --rerun, and nothing without."""
    if not wanted:
        return nullcontext()
    from twin.view.live import live

    return live()


def check_json_target(target: str | None) -> None:
    """Raise TwinError before long work when the JSON could not be written, or onto an input."""
    if target is None or target == "-":
        return
    keep_input(Path(target))
    parent = Path(str(target)).resolve().parent
    if not parent.is_dir() or not os.access(parent, os.W_OK) or Path(str(target)).is_dir():
        raise TwinError(f"{target}: cannot write the JSON there")


def refuse_doubles(files: Iterable[Path]) -> None:
    """Raise TwinError where a file is named twice: its data would count as two measurements."""
    known: set[Path] = set()
    for file in files:
        there = file.resolve()
        if there in known:
            raise TwinError(f"{file}: named twice; it would count as two measurements")
        known.add(there)


def keep_input(target: Path) -> None:
    """Raise TwinError where an output is a file that the command's line names a second time."""
    same = [a for a in _given if Path(a).is_file() and Path(a).resolve() == target.resolve()]
    if len(same) > 1:
        raise TwinError(f"{target}: this is an input of the command; write to another file")


def write_json(result: dict[str, Any], target: str | None) -> None:
    """Write ``result`` to a file, or to standard output for "-"; NaN is an error, not a value."""
    if target is None:
        return
    text = json.dumps(result, indent=1, allow_nan=False)
    if target == "-":
        print(text)
    else:
        write_whole(Path(target), lambda part: part.write_text(text + "\n"))
