"""Text files: their bytes, checked and decoded."""

from __future__ import annotations

import codecs
import gzip
import re
import zlib
from pathlib import Path

from twin.errors import RecordingError

_MARKS = (
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_GZIP = b"\x1f\x8b"
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f]")

LOOKED_AT = 200
"""Bytes at the beginning by which UTF-16 without a mark is recognised."""


def text_of(path: Path) -> str:
    """Return the text, with a line feed between lines; ``.gz`` is unpacked.

    It may be UTF-8, UTF-16 or UTF-32, or the Windows encoding of western Europe.

    Raises:
        RecordingError: bytes that no text has, or an archive that cannot be unpacked.
    """
    data = path.read_bytes()
    if path.suffix.lower() == ".gz":
        data = _unpacked(data, path)
    encoding = next((name for mark, name in _MARKS if data.startswith(mark)), _wide(data))
    if encoding:
        try:
            data = data.decode(encoding).encode("utf-8")
        except UnicodeError:
            raise RecordingError(
                f"{path}: {encoding.upper()} text that is damaged; save it as UTF-8"
            ) from None
    control = _CONTROL.search(data)
    if control:
        row = data.count(b"\n", 0, control.start()) + 1
        raise RecordingError(
            f"{path}: row {row} holds byte {control.group()[0]:#04x}: not a text file, or damaged"
        )
    data = data.removeprefix(codecs.BOM_UTF8).replace(b"\r\n", b"\n")
    if b"\n" not in data:
        data = data.replace(b"\r", b"\n")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def _unpacked(data: bytes, path: Path) -> bytes:
    if not data.startswith(_GZIP):
        raise RecordingError(f"{path}: this is not packed; rename it to {path.stem}")
    try:
        return gzip.decompress(data)
    except (OSError, EOFError, zlib.error):
        raise RecordingError(f"{path}: the archive is damaged or cut short") from None


def _wide(data: bytes) -> str | None:
    """Return the encoding of UTF-16 without a mark: every other byte of plain text is zero."""
    head = data[:LOOKED_AT]
    low, high = head[0::2], head[1::2]
    if len(head) > 8 and not any(high) and all(low):
        return "utf-16-le"
    if len(head) > 8 and not any(low) and all(high):
        return "utf-16-be"
    return None
