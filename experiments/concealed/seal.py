"""The truth, sealed: written apart, its SHA-256 kept, and refused when it has been touched."""

from __future__ import annotations

import hashlib
import json
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


def write_manifest(folder: Path, digests: dict[str, str]) -> Path:
    """Write the SHA-256 of every truth, before anything is diagnosed."""
    text = json.dumps(digests, indent=1, sort_keys=True) + "\n"
    return write_whole(folder / MANIFEST, lambda part: part.write_text(text))
