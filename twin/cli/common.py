"""Options and output that the commands share."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from twin.files import folder, write_whole

Out = Annotated[
    Path | None, typer.Option("--out", metavar="DIR", help="Folder for the files it writes.")
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Same seed, same result, bit for bit.")]
Json = Annotated[
    str | None,
    typer.Option("--json", metavar="FILE", help="Write the result as JSON; - for standard output."),
]


__all__ = ["Json", "Out", "Seed", "console", "folder", "write_json", "write_whole"]


def console(json_target: str | None) -> Console:
    """Return the console for people: standard error when standard output carries JSON."""
    return Console(stderr=json_target == "-", highlight=False, soft_wrap=False)


def write_json(result: dict[str, Any], target: str | None) -> None:
    """Write ``result`` to a file, or to standard output for "-"; NaN is an error, not a value."""
    if target is None:
        return
    text = json.dumps(result, indent=1, allow_nan=False)
    if target == "-":
        print(text)
    else:
        write_whole(Path(target), lambda part: part.write_text(text + "\n"))
