"""Files that a killed campaign may have left half-written: mended before they are read."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from twin.files import write_whole

PART = ".part-*"
"""Temporary files of ``write_whole``; a process that is killed leaves them."""


def mend(lines: Path) -> None:
    """Cut off the last line of a file of results where it is not whole.

    The shorter file replaces the longer at once: who is killed here, loses nothing.
    """
    if not lines.exists():
        return
    content = lines.read_bytes()
    whole = content[: content.rfind(b"\n") + 1]
    if not whole:
        lines.unlink()  # not even its first line was written
    elif whole != content:
        write_whole(lines, lambda part: part.write_bytes(whole))


def sweep(folder: Path) -> None:
    """Remove the temporary files that a kill left in a folder."""
    for part in folder.glob(PART) if folder.is_dir() else ():
        part.unlink(missing_ok=True)


def read_kept(path: Path) -> dict[str, Any] | None:
    """Return a stored diagnosis; None where there is none that is whole."""
    try:
        found = json.loads(path.read_text())
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None
