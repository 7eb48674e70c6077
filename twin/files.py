"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from twin.errors import TwinError


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
    if path.is_dir():
        raise TwinError(f"{path}: cannot write: this is a folder")
    folder(path.parent)
    part: Path | None = None
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=".part-", suffix=path.suffix)
        os.close(handle)
        part = Path(name)
        write(part)
        part.chmod(0o644)
        part.replace(path)
    except OSError as error:
        raise TwinError(f"{path}: cannot write ({error.strerror or error})") from None
    finally:
        if part is not None:
            part.unlink(missing_ok=True)
    return path
