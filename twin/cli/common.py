"""Options and output that the commands share."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from twin.errors import TwinError

Out = Annotated[
    Path | None, typer.Option("--out", metavar="DIR", help="Folder for the files it writes.")
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Same seed, same result, bit for bit.")]
Json = Annotated[
    str | None,
    typer.Option("--json", metavar="FILE", help="Write the result as JSON; - for standard output."),
]


def console(json_target: str | None) -> Console:
    """Return the console for people: standard error when standard output carries JSON."""
    return Console(stderr=json_target == "-", highlight=False, soft_wrap=False)


def folder(out: Path) -> Path:
    """Make the output folder. Raises TwinError when it cannot be made."""
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise TwinError(f"{out}: cannot make this folder ({error.strerror})") from None
    return out


def write_whole(path: Path, write: Callable[[Path], object]) -> Path:
    """Let ``write`` fill a temporary file beside ``path`` and move it there when it is whole.

    Nothing half-written is left behind, and an older file survives a failure.
    """
    folder(path.parent)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=".part-", suffix=path.suffix)
    os.close(handle)
    part = Path(name)
    try:
        write(part)
        part.chmod(0o644)
        part.replace(path)
    except OSError as error:
        raise TwinError(f"{path}: cannot write ({error.strerror})") from None
    finally:
        part.unlink(missing_ok=True)
    return path


def write_json(result: dict[str, Any], target: str | None) -> None:
    """Write ``result`` to a file, or to standard output for "-"; NaN is an error, not a value."""
    if target is None:
        return
    text = json.dumps(result, indent=1, allow_nan=False)
    if target == "-":
        print(text)
    else:
        write_whole(Path(target), lambda part: part.write_text(text + "\n"))
