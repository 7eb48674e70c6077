"""Text files: their bytes, checked and split into header and body."""

from __future__ import annotations

import codecs
import re
from pathlib import Path

from twin.errors import RecordingError

_UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f]")


def text_of(path: Path) -> tuple[bytes, str]:
    """Return the first line as bytes and the rest as text, with a line feed between lines.

    Raises:
        RecordingError: UTF-16, or bytes that no text has.
    """
    data = path.read_bytes()
    if data.startswith(_UTF_16):
        raise RecordingError(f"{path}: this is UTF-16 text; save it as UTF-8")
    control = _CONTROL.search(data)
    if control:
        row = data.count(b"\n", 0, control.start()) + 1
        raise RecordingError(
            f"{path}: row {row} holds byte {control.group()[0]:#04x}: not a text file, or damaged"
        )
    data = data.removeprefix(codecs.BOM_UTF8).replace(b"\r\n", b"\n")
    if b"\n" not in data:
        data = data.replace(b"\r", b"\n")
    head, _, body = data.partition(b"\n")
    # the numbers are ASCII; anything else becomes a cell that is refused by name
    return head, body.decode("ascii", errors="replace")


def header_text(head: bytes) -> str:
    """Return the header, in UTF-8 or in the Windows encoding of western Europe."""
    try:
        return head.decode("utf-8")
    except UnicodeDecodeError:
        return head.decode("cp1252", errors="replace")
