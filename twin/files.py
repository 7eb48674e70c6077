"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from twin.errors import TwinError

_written: set[Path] = set()
_replaced: dict[Path, Path] = {}


def replaced() -> list[str]:
    """Return the files that were there before this command wrote them, as they were named."""
    return [str(path) for path in _replaced.values()]


def forget() -> None:
    """Forget what was written: a new command begins."""
    _written.clear()
    _replaced.clear()


def folder(out: Path) -> Path:
    """Make the output folder. Raises TwinError when it cannot be made."""
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise TwinError(f"{out}: cannot make this folder ({error.strerror})") from None
    return out


def check_folder(out: Path) -> Path:
    """Return the folder. Raises TwinError when it could not be written, before the long work.

    Nothing is made yet: a command that fails leaves nothing behind.
    """
    there = out.absolute()
    while not there.exists():
        there = there.parent
    if not there.is_dir():
        raise TwinError(f"{out}: cannot make this folder ({there} is a file)")
    try:
        # permissions do not tell of a read-only disk, or of a folder that only looks like one
        with tempfile.TemporaryFile(dir=there):
            return out
    except OSError as error:
        reason = error.strerror or str(error)
        raise TwinError(f"{out}: cannot write there ({reason}: {there})") from None


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
        here = path.absolute()
        if path.exists() and here not in _written:
            _replaced[here] = path
        _written.add(here)
        part.replace(path)
    except OSError as error:
        raise TwinError(f"{path}: cannot write ({error.strerror or error})") from None
    finally:
        if part is not None:
            part.unlink(missing_ok=True)
    return path
