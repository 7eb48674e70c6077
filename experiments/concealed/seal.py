"""The truth, sealed: written apart, its SHA-256 kept first, and refused when it was touched."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from twin.errors import TwinError
from twin.files import write_whole

MANIFEST = "manifest.json"


def seal(path: Path, truth: dict[str, Any]) -> str:
    """Write a truth and return the SHA-256 of the file's bytes."""
    content = (json.dumps(truth, indent=1, allow_nan=False, sort_keys=True) + "\n").encode()
    write_whole(path, lambda part: part.write_bytes(content))
    return hashlib.sha256(content).hexdigest()


def open_seal(path: Path, digest: str) -> dict[str, Any]:
    """Return a truth.

    Raises:
        TwinError: it cannot be read, or is not the file that was sealed.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise TwinError(f"{path}: cannot read this truth ({error.strerror})") from None
    if hashlib.sha256(content).hexdigest() != digest:
        raise TwinError(f"{path}: the seal is broken: not the truth that was written down first")
    truth: dict[str, Any] = json.loads(content)
    return truth


def write_manifest(
    folder: Path, digests: Mapping[str, str], command: str, versions: Mapping[str, str]
) -> dict[str, Any]:
    """Write the SHA-256 of every truth, before anything is diagnosed, and return the manifest.

    A campaign that grows adds a piece: when, by which command and versions its cases were made.

    Raises:
        TwinError: an earlier manifest has another SHA-256 for one of the cases, or is unreadable.
    """
    path = folder / MANIFEST
    known = read_manifest(folder) if path.exists() else {"pieces": [], "sha256": {}}
    changed = [case for case, one in digests.items() if known["sha256"].get(case, one) != one]
    if changed:
        raise TwinError(f"{path}: the seal is broken: another truth was written for {changed[0]}")
    new = sorted(set(digests) - set(known["sha256"]))
    if not new:
        return known
    piece = {
        "written": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": command,
        "versions": dict(versions),
        "cases": len(new),
    }
    whole = {
        "pieces": [*known["pieces"], piece],
        "sha256": dict(sorted({**known["sha256"], **digests}.items())),
    }
    text = json.dumps(whole, indent=1) + "\n"
    write_whole(path, lambda part: part.write_text(text))
    return whole


def read_manifest(folder: Path) -> dict[str, Any]:
    """Return the manifest of a folder of sealed truths.

    Raises:
        TwinError: there is none, or it cannot be read.
    """
    path = folder / MANIFEST
    try:
        found = json.loads(path.read_text())
        if isinstance(found["pieces"], list) and isinstance(found["sha256"], dict):
            return {"pieces": found["pieces"], "sha256": found["sha256"]}
    except (OSError, ValueError, KeyError, TypeError):
        pass
    raise TwinError(f"{path}: no manifest of a campaign")
